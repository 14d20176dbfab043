"""Datasets: from solved presses and a camera to images of markers with known poses."""

from palpate.dataset.dataset import Dataset
from palpate.dataset.generate_dataset import generate_dataset
from palpate.dataset.io import dataset_version, read_dataset, write_dataset
from palpate.dataset.normalise import Normalisation, draw_jitter
from palpate.dataset.poses import sample_poses
from palpate.dataset.spec import DatasetSpec, RandomisationSpec
from palpate.dataset.split import LeakageError, check_leakage, hold_out
from palpate.dataset.vary import PerturbedPresses

__all__ = [
    "Dataset",
    "DatasetSpec",
    "LeakageError",
    "Normalisation",
    "PerturbedPresses",
    "RandomisationSpec",
    "check_leakage",
    "dataset_version",
    "draw_jitter",
    "generate_dataset",
    "hold_out",
    "read_dataset",
    "sample_poses",
    "write_dataset",
]
