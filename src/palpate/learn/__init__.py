"""Learning: from images of markers to the pose of the wall, and how good any estimator could be."""

from palpate.learn.estimator import LEARN_VERSION, Estimator
from palpate.learn.io import read_estimator, write_estimator
from palpate.learn.limit import DepthLimit, find_limits
from palpate.learn.metrics import DepthErrors, ErrorSummary, Metrics, measure_errors
from palpate.learn.search import search
from palpate.learn.spec import SearchSpec, TrainSpec, paper_training
from palpate.learn.train import evaluate, fit_ridge, train

__all__ = [
    "LEARN_VERSION",
    "DepthErrors",
    "DepthLimit",
    "ErrorSummary",
    "Estimator",
    "Metrics",
    "SearchSpec",
    "TrainSpec",
    "evaluate",
    "find_limits",
    "fit_ridge",
    "measure_errors",
    "paper_training",
    "read_estimator",
    "search",
    "train",
    "write_estimator",
]
