"""Design search: requirements in, the best sensors that a workshop can build out."""

from palpate.optimise.choose_rings import (
    PrintLimits,
    RingCandidates,
    RingSelection,
    bound_rings,
    choose_rings,
    measure_ring_candidates,
)
from palpate.optimise.design_study import write_packs
from palpate.optimise.front import DesignCandidate, Front, SkinTrial
from palpate.optimise.optimise_design import optimise_design, validate_front
from palpate.optimise.search_folder import SearchFolder, is_search, read_search
from palpate.optimise.search_skins import Evaluation, SearchPlan, SearchTrial, search_skins
from palpate.optimise.skin_evaluation import LayoutOption, SkinEvaluation
from palpate.optimise.sobol import compute_sobol_indices
from palpate.optimise.space import SkinSpace
from palpate.optimise.spec import BaselineDesignSpec, CameraChoice, RequirementsSpec, read_requirements
from palpate.optimise.validation import SimulatedAccuracy, SolverComparison, ValidatedDesign, ValidationResult
from palpate.optimise.write_front import FRONT_COLUMNS, describe_front, write_front

__all__ = [
    "FRONT_COLUMNS",
    "BaselineDesignSpec",
    "CameraChoice",
    "DesignCandidate",
    "Evaluation",
    "Front",
    "LayoutOption",
    "PrintLimits",
    "RequirementsSpec",
    "RingCandidates",
    "RingSelection",
    "SearchFolder",
    "SearchPlan",
    "SearchTrial",
    "SimulatedAccuracy",
    "SkinEvaluation",
    "SkinSpace",
    "SkinTrial",
    "SolverComparison",
    "ValidatedDesign",
    "ValidationResult",
    "bound_rings",
    "choose_rings",
    "compute_sobol_indices",
    "describe_front",
    "is_search",
    "measure_ring_candidates",
    "optimise_design",
    "read_requirements",
    "read_search",
    "search_skins",
    "validate_front",
    "write_front",
    "write_packs",
]
