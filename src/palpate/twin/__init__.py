"""Twin: the forward model of a built unit, from the pose of what presses it to the pixels of its markers."""

from palpate.twin.build_twin import THICKNESS, build_twin
from palpate.twin.deviation import IMPERFECTIONS, Deviation, Imperfection, draw_deviation, single_deviation
from palpate.twin.field import MarkerField, build_field
from palpate.twin.foresee import BuiltFigure, ForeseeSpec, foresee
from palpate.twin.identify import (
    MODEL_PX,
    MOUNTING,
    SLIP_MEAN,
    SLIP_MOST,
    SLIP_SD,
    Identified,
    Mounting,
    RobotPress,
    RobotSpec,
    identify,
    mount_unit,
    weigh_dots,
)
from palpate.twin.jacobian import image_jacobian
from palpate.twin.tilt_runs import TiltRuns, cut_into_runs, label_presses, match_depths, shared_depths
from palpate.twin.tolerance import ToleranceSpec
from palpate.twin.twin import Motion, PrintedTwin, Twin
from palpate.twin.twin_file import TWIN_VERSION, read_twin, write_twin
from palpate.twin.unit_file import KnownUnit, read_unit, write_unit
from palpate.twin.unit_model import UNKNOWN, Look, UnitBelief, UnitModel, learn_rest, model_unit

__all__ = [
    "IMPERFECTIONS",
    "MODEL_PX",
    "MOUNTING",
    "SLIP_MEAN",
    "SLIP_MOST",
    "SLIP_SD",
    "THICKNESS",
    "TWIN_VERSION",
    "UNKNOWN",
    "BuiltFigure",
    "Deviation",
    "ForeseeSpec",
    "Identified",
    "Imperfection",
    "KnownUnit",
    "Look",
    "MarkerField",
    "Motion",
    "Mounting",
    "PrintedTwin",
    "RobotPress",
    "RobotSpec",
    "TiltRuns",
    "ToleranceSpec",
    "Twin",
    "UnitBelief",
    "UnitModel",
    "build_field",
    "build_twin",
    "cut_into_runs",
    "draw_deviation",
    "foresee",
    "identify",
    "image_jacobian",
    "label_presses",
    "learn_rest",
    "match_depths",
    "model_unit",
    "mount_unit",
    "read_twin",
    "read_unit",
    "shared_depths",
    "single_deviation",
    "weigh_dots",
    "write_twin",
    "write_unit",
]
