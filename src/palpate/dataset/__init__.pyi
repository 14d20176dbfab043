"""Datasets: from solved presses and a camera to images of markers with known poses."""

from palpate.dataset.dataset import Dataset
from palpate.dataset.generate_dataset import generate_dataset
from palpate.dataset.io import dataset_version, read_dataset, write_dataset
from palpate.dataset.normalise import Normalisation, draw_jitter
from palpate.dataset.poses import sample_poses
from palpate.dataset.spec import DatasetSpec, RandomisationSpec
from palpate.dataset.split import LeakageError, PressSplit, check_leakage, split_presses
from palpate.dataset.vary import PerturbedPresses

__all__ = [
    "Dataset",
    "DatasetSpec",
    "LeakageError",
    "Normalisation",
    "PerturbedPresses",
    "PressSplit",
    "RandomisationSpec",
    "check_leakage",
    "dataset_version",
    "draw_jitter",
    "generate_dataset",
    "read_dataset",
    "sample_poses",
    "split_presses",
    "write_dataset",
]
