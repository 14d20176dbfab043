"""Learning: from images of markers, simulated or recorded, to the pose of the wall with an honest interval."""

from palpate.learn.calibrate import Coverage, calibrate_interval, measure_coverage
from palpate.learn.compare_with_bound import compare_with_bound, find_leakage, pool_bounds
from palpate.learn.control import compare_splits, shuffle_labels
from palpate.learn.device import find_device
from palpate.learn.error_bound import ErrorBound, compute_error_bounds
from palpate.learn.estimator import Estimator
from palpate.learn.fine_tune import PretrainedModel, read_pretrained
from palpate.learn.force_graph import train_force_output
from palpate.learn.interval import Prediction, press_quantile
from palpate.learn.io import read_estimator, write_estimator
from palpate.learn.member import EFFORTS, ESTIMATORS, EnsembleMember, ImageNetwork, TrainingRun
from palpate.learn.metrics import DepthErrors, ErrorSummary, Metrics, TiltErrors, measure_errors
from palpate.learn.predictor import Predictor, open_predictor
from palpate.learn.prepare_recording import prepare_recording
from palpate.learn.recording_model import RecordedModel, is_recorded_model, read_model, write_model
from palpate.learn.recording_report import draw_recording_report, recording_page, recording_report
from palpate.learn.recording_spec import RecordingSpec
from palpate.learn.rotation import RotationAugmentation
from palpate.learn.search_estimator import search_estimator
from palpate.learn.simulated_start import SimulatedStart
from palpate.learn.space import PAPER_SPACE
from palpate.learn.spec import LearningSpec, TrainingSpec, paper_training
from palpate.learn.train import evaluate, fit_ridge, train
from palpate.learn.train_members import TrainingJob, train_members
from palpate.learn.train_on_recording import RecordingResult, train_on_recording
from palpate.learn.training_set import TrainingSet

__all__ = [
    "EFFORTS",
    "ESTIMATORS",
    "PAPER_SPACE",
    "Coverage",
    "DepthErrors",
    "EnsembleMember",
    "ErrorBound",
    "ErrorSummary",
    "Estimator",
    "ImageNetwork",
    "LearningSpec",
    "Metrics",
    "Prediction",
    "Predictor",
    "PretrainedModel",
    "RecordedModel",
    "RecordingResult",
    "RecordingSpec",
    "RotationAugmentation",
    "SimulatedStart",
    "TiltErrors",
    "TrainingJob",
    "TrainingRun",
    "TrainingSet",
    "TrainingSpec",
    "calibrate_interval",
    "compare_splits",
    "compare_with_bound",
    "compute_error_bounds",
    "draw_recording_report",
    "evaluate",
    "find_device",
    "find_leakage",
    "fit_ridge",
    "is_recorded_model",
    "measure_coverage",
    "measure_errors",
    "open_predictor",
    "paper_training",
    "pool_bounds",
    "prepare_recording",
    "press_quantile",
    "read_estimator",
    "read_model",
    "read_pretrained",
    "recording_page",
    "recording_report",
    "search_estimator",
    "shuffle_labels",
    "train",
    "train_force_output",
    "train_members",
    "train_on_recording",
    "write_estimator",
    "write_model",
]
