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
from palpate.material.rank import extrapolate_modes, rank_models
from palpate.material.read_bench import read_test_file
from palpate.material.read_relaxation import read_relaxation
from palpate.material.sample import Loading, Sample
from palpate.material.secant import SECANT_TOLERANCE, compare_secants
from palpate.material.spec import FitSpec, PrepareSpec, TestFileSpec, Weighting

__all__ = [
    "LAWS",
    "SECANT_TOLERANCE",
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
    "TestFileSpec",
    "Weighting",
    "compare_secants",
    "draw_fit",
    "extrapolate_modes",
    "find_stable_ranges",
    "fit_material",
    "get_material",
    "list_materials",
    "list_models",
    "material_from_data",
    "prepare_sample",
    "rank_models",
    "read_material",
    "read_relaxation",
    "read_test_file",
    "save_figure",
    "stretches",
    "trace_curve",
    "write_material",
]
