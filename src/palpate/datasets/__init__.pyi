"""Datasets: images of markers with known poses, simulated from presses or read from recordings."""

from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.dataset import Dataset
from palpate.datasets.generate_dataset import generate_dataset
from palpate.datasets.io import dataset_version, read_dataset, write_dataset
from palpate.datasets.normalise import Normalisation, draw_jitter
from palpate.datasets.pose_column import PoseColumn
from palpate.datasets.poses import sample_poses
from palpate.datasets.quantities import find_quantities
from palpate.datasets.randomise import PerturbedPresses
from palpate.datasets.read_recording import LEAST_PRESSES, Recording, read_recording
from palpate.datasets.recording_columns import find_image_column, find_press_column
from palpate.datasets.recording_images import ImageSet, find_files
from palpate.datasets.recording_reader import READERS, RecordingReader
from palpate.datasets.spec import DatasetSpec, RandomisationSpec
from palpate.datasets.split import PressSplit, check_leakage, split_presses
from palpate.datasets.surface_poses import to_surface
from palpate.datasets.table import REST, RecordingTable, read_table

__all__ = [
    "LEAST_PRESSES",
    "READERS",
    "REST",
    "ColumnMapping",
    "Dataset",
    "DatasetSpec",
    "ImageSet",
    "Normalisation",
    "PerturbedPresses",
    "PoseColumn",
    "PressSplit",
    "RandomisationSpec",
    "Recording",
    "RecordingReader",
    "RecordingTable",
    "check_leakage",
    "dataset_version",
    "draw_jitter",
    "find_files",
    "find_image_column",
    "find_press_column",
    "find_quantities",
    "generate_dataset",
    "read_dataset",
    "read_recording",
    "read_table",
    "sample_poses",
    "split_presses",
    "to_surface",
    "write_dataset",
]
