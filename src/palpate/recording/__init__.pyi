"""Recordings: images of any sensor with dots, and poses beside them, to a model that reads it."""

from palpate.recording.adapt import PretrainedModel, read_pretrained
from palpate.recording.assign import AssignedMarkers, assign_images, choose_reference
from palpate.recording.columns import ColumnMapping, PoseColumn
from palpate.recording.conclude import EstimatorScore
from palpate.recording.correspond import Correspondence, MarkerMatcher, MatchFault
from palpate.recording.layout import ObservedLayout, number_markers
from palpate.recording.learn_recording import RecordingResult, train_on_recording
from palpate.recording.model import PoseReading, RecordedModel, is_recorded_model, read_model, write_model
from palpate.recording.read_recording import Recording, read_recording
from palpate.recording.report import draw_recording_report, recording_page, recording_report
from palpate.recording.see_recording import PreparedRecording, prepare_recording
from palpate.recording.spec import RecordingSpec
from palpate.recording.table import RecordingTable, read_table

__all__ = [
    "AssignedMarkers",
    "ColumnMapping",
    "Correspondence",
    "EstimatorScore",
    "MarkerMatcher",
    "MatchFault",
    "ObservedLayout",
    "PoseColumn",
    "PoseReading",
    "PreparedRecording",
    "PretrainedModel",
    "RecordedModel",
    "Recording",
    "RecordingResult",
    "RecordingSpec",
    "RecordingTable",
    "assign_images",
    "choose_reference",
    "draw_recording_report",
    "is_recorded_model",
    "number_markers",
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
