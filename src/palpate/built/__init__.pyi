"""Built: a unit as it was built: tolerances, what its images tell of it, poses by fit, and how good it will be."""

from palpate.built.deviation import IMPERFECTIONS, Deviation, Imperfection, sample_deviation, single_deviation
from palpate.built.fit_pose import PoseFitter
from palpate.built.force import Force, StiffnessScale, predict_force, prior_stiffness_scale, update_stiffness_scale
from palpate.built.foresee import AccuracySpec, PredictedAccuracy, predict_accuracy
from palpate.built.foresee_budget import predict_budget
from palpate.built.identify import ContradictionError, IdentificationResult, identify
from palpate.built.next_press import rank_next_presses
from palpate.built.noise import NOISE_PX
from palpate.built.pose_fit import CONTACT_STATE, FitState, PoseFit
from palpate.built.ring_information import RingInformation, compute_ring_information
from palpate.built.robot_press import CALIBRATION_TILTS, CalibrationPress, RobotUncertainty, calibration_pose
from palpate.built.tolerance import ToleranceSpec
from palpate.built.twin_error import ValidationPresses
from palpate.built.unit_file import IdentifiedUnit, read_unit, write_unit
from palpate.built.unit_model import UNIT_PARAMETERS, PredictedImage, UnitModel, build_unit_model, infer_from_rest

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
    "PredictedImage",
    "RingInformation",
    "RobotUncertainty",
    "StiffnessScale",
    "ToleranceSpec",
    "UnitModel",
    "ValidationPresses",
    "build_unit_model",
    "calibration_pose",
    "compute_ring_information",
    "identify",
    "infer_from_rest",
    "predict_accuracy",
    "predict_budget",
    "predict_force",
    "prior_stiffness_scale",
    "rank_next_presses",
    "read_unit",
    "sample_deviation",
    "single_deviation",
    "update_stiffness_scale",
    "write_unit",
]
