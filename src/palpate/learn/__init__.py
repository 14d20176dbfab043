"""Learning: from images of markers to the pose of the wall, and how good any estimator could be."""

from palpate.learn.calibrate import Coverage, calibrate, measure_coverage
from palpate.learn.control import compare_splits, shuffle_labels
from palpate.learn.device import find_device
from palpate.learn.estimator import Estimator
from palpate.learn.force_graph import learn_forces
from palpate.learn.interval import Interval, Prediction
from palpate.learn.io import read_estimator, write_estimator
from palpate.learn.judge import compare_with_limit, find_leak, pool_limits
from palpate.learn.limit import DepthLimit, find_limits
from palpate.learn.metrics import DepthErrors, ErrorSummary, Metrics, TiltErrors, measure_errors
from palpate.learn.predictor import Predictor, open_predictor
from palpate.learn.search import search
from palpate.learn.space import PAPER_SPACE
from palpate.learn.spec import SearchSpec, TrainSpec, paper_training
from palpate.learn.train import evaluate, fit_ridge, train

__all__ = [
    "PAPER_SPACE",
    "Coverage",
    "DepthErrors",
    "DepthLimit",
    "ErrorSummary",
    "Estimator",
    "Interval",
    "Metrics",
    "Prediction",
    "Predictor",
    "SearchSpec",
    "TiltErrors",
    "TrainSpec",
    "calibrate",
    "compare_splits",
    "compare_with_limit",
    "evaluate",
    "find_device",
    "find_leak",
    "find_limits",
    "fit_ridge",
    "learn_forces",
    "measure_coverage",
    "measure_errors",
    "open_predictor",
    "paper_training",
    "pool_limits",
    "read_estimator",
    "search",
    "shuffle_labels",
    "train",
    "write_estimator",
]
