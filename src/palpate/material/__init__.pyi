"""Material: laws of elastomers, fitted to test files, and their relaxation."""

from palpate.material.choose import get_material, list_materials, material_from_data
from palpate.material.curve import Mode, stretches, trace_curve
from palpate.material.draw import draw_fit, save_figure
from palpate.material.draw_relaxation import draw_relaxation
from palpate.material.drucker import find_stable_ranges
from palpate.material.fit import Fit
from palpate.material.fit_material import fit_material
from palpate.material.fit_relaxation import RelaxationFit, fit_relaxation
from palpate.material.io import read_material, write_material
from palpate.material.law import DeckLine, Law, Model
from palpate.material.laws.neo_hooke import NeoHooke
from palpate.material.make_law import LAWS, list_models
from palpate.material.material import Material
from palpate.material.model import LinearModel
from palpate.material.prepare import prepare_sample
from palpate.material.rank import extrapolate_modes, rank_models
from palpate.material.read_relaxation import read_relaxation
from palpate.material.read_test_file import read_test_file
from palpate.material.relaxation import Moduli, Relaxation
from palpate.material.relaxation_history import StressHistory, relax_history
from palpate.material.relaxation_test import RelaxationTest
from palpate.material.sample import Loading, Sample
from palpate.material.secant import SECANT_TOLERANCE, compare_secants
from palpate.material.spec import FitSpec, PrepareSpec, TestFileSpec, Weighting
from palpate.material.wall_history import (
    ForceCurve,
    simulate_compliant_hold,
    simulate_depth_hold,
    simulate_force_hold,
)

__all__ = [
    "LAWS",
    "SECANT_TOLERANCE",
    "DeckLine",
    "Fit",
    "FitSpec",
    "ForceCurve",
    "Law",
    "LinearModel",
    "Loading",
    "Material",
    "Mode",
    "Model",
    "Moduli",
    "NeoHooke",
    "PrepareSpec",
    "Relaxation",
    "RelaxationFit",
    "RelaxationTest",
    "Sample",
    "StressHistory",
    "TestFileSpec",
    "Weighting",
    "compare_secants",
    "draw_fit",
    "draw_relaxation",
    "extrapolate_modes",
    "find_stable_ranges",
    "fit_material",
    "fit_relaxation",
    "get_material",
    "list_materials",
    "list_models",
    "material_from_data",
    "prepare_sample",
    "rank_models",
    "read_material",
    "read_relaxation",
    "read_test_file",
    "relax_history",
    "save_figure",
    "simulate_compliant_hold",
    "simulate_depth_hold",
    "simulate_force_hold",
    "stretches",
    "trace_curve",
    "write_material",
]
