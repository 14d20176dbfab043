"""Recordings: images of any sensor with dots, and poses beside them, to a model that reads it."""

from palpate.recording.adapt import Start, read_start
from palpate.recording.assign import Assigned, assign_images, choose_reference
from palpate.recording.columns import Choice, PoseColumn
from palpate.recording.conclude import PartScore
from palpate.recording.correspond import Correspondence, Correspondent, Fault
from palpate.recording.course import CourseSpec
from palpate.recording.curve import CurvePoint
from palpate.recording.layout import DotLayout, number_dots
from palpate.recording.learn_recording import Learnt, learn_recording
from palpate.recording.lesson import Lesson
from palpate.recording.model import PoseReading, RecordedModel, is_recorded_model, read_model, write_model
from palpate.recording.read_recording import Recording, read_recording
from palpate.recording.report import draw_recording_report, recording_page, recording_report
from palpate.recording.see_recording import Seen, see_recording
from palpate.recording.spec import RecordingSpec
from palpate.recording.table import RecordingTable, read_table
from palpate.recording.train_part import train_picture_network

__all__ = [
    "Assigned",
    "Choice",
    "Correspondence",
    "Correspondent",
    "CourseSpec",
    "CurvePoint",
    "DotLayout",
    "Fault",
    "Learnt",
    "Lesson",
    "PartScore",
    "PoseColumn",
    "PoseReading",
    "RecordedModel",
    "Recording",
    "RecordingSpec",
    "RecordingTable",
    "Seen",
    "Start",
    "assign_images",
    "choose_reference",
    "draw_recording_report",
    "is_recorded_model",
    "learn_recording",
    "number_dots",
    "read_model",
    "read_recording",
    "read_start",
    "read_table",
    "recording_page",
    "recording_report",
    "see_recording",
    "train_picture_network",
    "write_model",
]
