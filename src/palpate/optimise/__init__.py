"""Design search: requirements in, the best sensors that a workshop can build out."""

from palpate.optimise.choose_rings import ChosenRings, PrintLimits, RingPlaces, bound_rings, choose_rings, place_rings
from palpate.optimise.design_study import write_packs
from palpate.optimise.front import Entry, Front, TriedSkin
from palpate.optimise.influence import Influences, find_influences
from palpate.optimise.optimise_design import optimise_design, prove_front
from palpate.optimise.proof import BenchFigure, Proof, ProvenDesign, SecondSolver
from palpate.optimise.proposal import Proposal, Variant
from palpate.optimise.search_folder import FoundDesign, SearchFolder, is_search, read_search
from palpate.optimise.search_skins import Judged, SearchPlan, Tried, search_skins
from palpate.optimise.space import SkinSpace
from palpate.optimise.spec import CameraChoice, RequirementsSpec, RivalSpec, read_requirements
from palpate.optimise.write_front import describe_front, write_front

__all__ = [
    "BenchFigure",
    "CameraChoice",
    "ChosenRings",
    "Entry",
    "FoundDesign",
    "Front",
    "Influences",
    "Judged",
    "PrintLimits",
    "Proof",
    "Proposal",
    "ProvenDesign",
    "RequirementsSpec",
    "RingPlaces",
    "RivalSpec",
    "SearchFolder",
    "SearchPlan",
    "SecondSolver",
    "SkinSpace",
    "Tried",
    "TriedSkin",
    "Variant",
    "bound_rings",
    "choose_rings",
    "describe_front",
    "find_influences",
    "is_search",
    "optimise_design",
    "place_rings",
    "prove_front",
    "read_requirements",
    "read_search",
    "search_skins",
    "write_front",
    "write_packs",
]
