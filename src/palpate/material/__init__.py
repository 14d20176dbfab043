"""Material: cured elastomers as nearly incompressible hyperelastic laws, with the pedigree of their numbers."""

from palpate.material.choose import get_material, list_materials, material_from_data
from palpate.material.curve import Curve, Mode, stretches, trace_curve
from palpate.material.draw import draw_fit, save_figure
from palpate.material.drucker import find_stable_ranges
from palpate.material.fit import Fit
from palpate.material.fit_material import fit_material
from palpate.material.io import read_material, write_material
from palpate.material.law import DeckLine, Law, Model
from palpate.material.laws.neo_hooke import NeoHooke
from palpate.material.make_law import LAWS, list_models
from palpate.material.material import Material
from palpate.material.model import LinearModel
from palpate.material.prepare import prepare_sample
from palpate.material.rank import predict_unseen, rank_models
from palpate.material.read_bench import read_bench
from palpate.material.read_relaxation import read_relaxation
from palpate.material.sample import Loading, Sample
from palpate.material.secant import DIFFERS, compare_secants
from palpate.material.spec import BenchSpec, FitSpec, PrepareSpec, Weighting

__all__ = [
    "DIFFERS",
    "LAWS",
    "BenchSpec",
    "Curve",
    "DeckLine",
    "Fit",
    "FitSpec",
    "Law",
    "LinearModel",
    "Loading",
    "Material",
    "Mode",
    "Model",
    "NeoHooke",
    "PrepareSpec",
    "Sample",
    "Weighting",
    "compare_secants",
    "draw_fit",
    "find_stable_ranges",
    "fit_material",
    "get_material",
    "list_materials",
    "list_models",
    "material_from_data",
    "predict_unseen",
    "prepare_sample",
    "rank_models",
    "read_bench",
    "read_material",
    "read_relaxation",
    "save_figure",
    "stretches",
    "trace_curve",
    "write_material",
]
