"""Calibration: deviations of built units, what images tell of them, and their predicted accuracy."""

from palpate.calibration.calibration_press import (
    CALIBRATION_TILTS,
    CalibrationPress,
    RobotUncertainty,
    calibration_pose,
)
from palpate.calibration.deviation import IMPERFECTIONS, Deviation, Imperfection, sample_deviation, single_deviation
from palpate.calibration.fit_pose import PoseFitter
from palpate.calibration.force import (
    Force,
    ScalarEstimate,
    predict_force,
    prior_stiffness_scale,
    update_stiffness_scale,
)
from palpate.calibration.identify import ContradictionError, IdentificationResult, identify
from palpate.calibration.next_press import rank_next_presses
from palpate.calibration.noise import NOISE_PX
from palpate.calibration.pose_fit import CONTACT_STATE, FitState, PoseFit
from palpate.calibration.predict_accuracy import AccuracySpec, PredictedAccuracy, predict_accuracy
from palpate.calibration.ring_information import RingInformation, compute_ring_information
from palpate.calibration.tolerance import ToleranceSpec
from palpate.calibration.twin_error import ValidationPresses
from palpate.calibration.uncertainty import UncertaintyBudget
from palpate.calibration.unit_file import IdentifiedUnit, read_unit, write_unit
from palpate.calibration.unit_model import UNIT_PARAMETERS, UnitModel, build_unit_model, infer_from_rest

__all__ = [
    "CALIBRATION_TILTS",
    "CONTACT_STATE",
    "IMPERFECTIONS",
    "NOISE_PX",
    "UNIT_PARAMETERS",
    "AccuracySpec",
    "CalibrationPress",
    "ContradictionError",
    "Deviation",
    "FitState",
    "Force",
    "IdentificationResult",
    "IdentifiedUnit",
    "Imperfection",
    "PoseFit",
    "PoseFitter",
    "PredictedAccuracy",
    "RingInformation",
    "RobotUncertainty",
    "ScalarEstimate",
    "ToleranceSpec",
    "UncertaintyBudget",
    "UnitModel",
    "ValidationPresses",
    "build_unit_model",
    "calibration_pose",
    "compute_ring_information",
    "identify",
    "infer_from_rest",
    "predict_accuracy",
    "predict_force",
    "prior_stiffness_scale",
    "rank_next_presses",
    "read_unit",
    "sample_deviation",
    "single_deviation",
    "update_stiffness_scale",
    "write_unit",
]
