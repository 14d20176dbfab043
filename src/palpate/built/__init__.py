"""Built: a unit as it was built: tolerances, what its images tell of it, poses by fit, and how good it will be."""

from palpate.built.deviation import IMPERFECTIONS, Deviation, Imperfection, draw_deviation, single_deviation
from palpate.built.fit_pose import PoseFitter
from palpate.built.force import Force, ForceScale, expect_force, expect_scale, learn_scale
from palpate.built.foresee import FORESEE_VERSION, BuiltFigure, ForeseeSpec, foresee
from palpate.built.foresee_budget import foresee_budget
from palpate.built.identify import ContradictionError, Identified, identify
from palpate.built.next_press import rank_presses
from palpate.built.noise import NOISE_PX
from palpate.built.pose_fit import FitState, PoseFit
from palpate.built.ring_information import RingInformation, measure_rings
from palpate.built.robot_press import KNOWN_TILTS, KNOWN_TURN_DEG, RobotPress, RobotSpec
from palpate.built.tolerance import ToleranceSpec
from palpate.built.twin_error import TwinChecks
from palpate.built.unit_file import KnownUnit, read_unit, write_unit
from palpate.built.unit_model import UNKNOWN, Look, UnitModel, learn_rest, model_unit

__all__ = [
    "FORESEE_VERSION",
    "IMPERFECTIONS",
    "KNOWN_TILTS",
    "KNOWN_TURN_DEG",
    "NOISE_PX",
    "UNKNOWN",
    "BuiltFigure",
    "ContradictionError",
    "Deviation",
    "FitState",
    "Force",
    "ForceScale",
    "ForeseeSpec",
    "Identified",
    "Imperfection",
    "KnownUnit",
    "Look",
    "PoseFit",
    "PoseFitter",
    "RingInformation",
    "RobotPress",
    "RobotSpec",
    "ToleranceSpec",
    "TwinChecks",
    "UnitModel",
    "draw_deviation",
    "expect_force",
    "expect_scale",
    "foresee",
    "foresee_budget",
    "identify",
    "learn_rest",
    "learn_scale",
    "measure_rings",
    "model_unit",
    "rank_presses",
    "read_unit",
    "single_deviation",
    "write_unit",
]
