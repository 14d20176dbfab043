"""Recordings: images of any sensor with dots, and poses beside them, to a model that reads it."""

from palpate.recording.adapt import PretrainedModel, read_pretrained
from palpate.recording.columns import ColumnMapping, PoseColumn
from palpate.recording.conclude import EstimatorScore
from palpate.recording.images import ImageSet
from palpate.recording.learn_recording import RecordingResult, train_on_recording
from palpate.recording.model import PoseReading, RecordedModel, is_recorded_model, read_model, write_model
from palpate.recording.read_recording import Recording, read_recording
from palpate.recording.reader import READERS, RecordingReader
from palpate.recording.report import draw_recording_report, recording_page, recording_report
from palpate.recording.see_recording import PreparedRecording, prepare_recording
from palpate.recording.spec import RecordingSpec
from palpate.recording.table import RecordingTable, read_table

__all__ = [
    "READERS",
    "ColumnMapping",
    "EstimatorScore",
    "ImageSet",
    "PoseColumn",
    "PoseReading",
    "PreparedRecording",
    "PretrainedModel",
    "RecordedModel",
    "Recording",
    "RecordingReader",
    "RecordingResult",
    "RecordingSpec",
    "RecordingTable",
    "draw_recording_report",
    "is_recorded_model",
    "prepare_recording",
    "read_model",
    "read_pretrained",
    "read_recording",
    "read_table",
    "recording_page",
    "recording_report",
    "train_on_recording",
    "write_model",
]
