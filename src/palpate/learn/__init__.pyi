"""Learning: from images of markers to the pose of the wall, and how good any estimator could be."""

from palpate.learn.calibrate import Coverage, calibrate_interval, measure_coverage
from palpate.learn.control import compare_splits, shuffle_labels
from palpate.learn.device import find_device
from palpate.learn.estimator import Estimator
from palpate.learn.force_graph import train_force_output
from palpate.learn.interval import Interval, Prediction, press_quantile
from palpate.learn.io import read_estimator, write_estimator
from palpate.learn.judge import compare_with_bound, find_leakage, pool_bounds
from palpate.learn.limit import ErrorBound, compute_error_bounds
from palpate.learn.metrics import DepthErrors, ErrorSummary, Metrics, TiltErrors, measure_errors
from palpate.learn.predictor import Predictor, open_predictor
from palpate.learn.search import search_estimator
from palpate.learn.space import PAPER_SPACE
from palpate.learn.spec import LearningSpec, TrainingSpec, paper_training
from palpate.learn.train import evaluate, fit_ridge, train

__all__ = [
    "PAPER_SPACE",
    "Coverage",
    "DepthErrors",
    "ErrorBound",
    "ErrorSummary",
    "Estimator",
    "Interval",
    "LearningSpec",
    "Metrics",
    "Prediction",
    "Predictor",
    "TiltErrors",
    "TrainingSpec",
    "calibrate_interval",
    "compare_splits",
    "compare_with_bound",
    "compute_error_bounds",
    "evaluate",
    "find_device",
    "find_leakage",
    "fit_ridge",
    "measure_coverage",
    "measure_errors",
    "open_predictor",
    "paper_training",
    "pool_bounds",
    "press_quantile",
    "read_estimator",
    "search_estimator",
    "shuffle_labels",
    "train",
    "train_force_output",
    "write_estimator",
]
