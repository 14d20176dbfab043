"""Learning: from images of markers to the pose of the wall, and how good any estimator could be."""

from palpate.learn.calibrate import Coverage, calibrate_interval, measure_coverage
from palpate.learn.control import compare_splits, shuffle_labels
from palpate.learn.device import find_device
from palpate.learn.ensemble import Ensemble, select_ensemble
from palpate.learn.estimator import Estimator
from palpate.learn.force_graph import train_force_output
from palpate.learn.interval import Interval, Prediction, press_quantile
from palpate.learn.io import read_estimator, write_estimator
from palpate.learn.judge import compare_with_bound, find_leakage, pool_bounds
from palpate.learn.learning_curve import CurvePoint, compute_learning_curve, extrapolate_learning_curve, train_quickly
from palpate.learn.limit import ErrorBound, compute_error_bounds
from palpate.learn.member import (
    EFFORTS,
    ESTIMATORS,
    EnsembleMember,
    ImageNetwork,
    MarkerNetwork,
    TrainingRun,
    open_member,
)
from palpate.learn.metrics import DepthErrors, ErrorSummary, Metrics, TiltErrors, measure_errors
from palpate.learn.predictor import Predictor, open_predictor
from palpate.learn.ridge import solve_ridge
from palpate.learn.rotation import RotationAugmentation, find_rotation, pattern_order
from palpate.learn.search import search_estimator
from palpate.learn.space import PAPER_SPACE
from palpate.learn.spec import LearningSpec, TrainingSpec, paper_training
from palpate.learn.train import evaluate, fit_ridge, train
from palpate.learn.train_members import TrainingJob, train_members
from palpate.learn.training_set import TrainingSet

__all__ = [
    "EFFORTS",
    "ESTIMATORS",
    "PAPER_SPACE",
    "Coverage",
    "CurvePoint",
    "DepthErrors",
    "Ensemble",
    "EnsembleMember",
    "ErrorBound",
    "ErrorSummary",
    "Estimator",
    "ImageNetwork",
    "Interval",
    "LearningSpec",
    "MarkerNetwork",
    "Metrics",
    "Prediction",
    "Predictor",
    "RotationAugmentation",
    "TiltErrors",
    "TrainingJob",
    "TrainingRun",
    "TrainingSet",
    "TrainingSpec",
    "calibrate_interval",
    "compare_splits",
    "compare_with_bound",
    "compute_error_bounds",
    "compute_learning_curve",
    "evaluate",
    "extrapolate_learning_curve",
    "find_device",
    "find_leakage",
    "find_rotation",
    "fit_ridge",
    "measure_coverage",
    "measure_errors",
    "open_member",
    "open_predictor",
    "paper_training",
    "pattern_order",
    "pool_bounds",
    "press_quantile",
    "read_estimator",
    "search_estimator",
    "select_ensemble",
    "shuffle_labels",
    "solve_ridge",
    "train",
    "train_force_output",
    "train_members",
    "train_quickly",
    "write_estimator",
]
