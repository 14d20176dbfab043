"""Markers: from images to dots, their numbers and their paths through a press."""

from palpate.markers.blobs import Blobs
from palpate.markers.detector import Detector, prepare_detector
from palpate.markers.motion import MotionModel, fit_motion_model
from palpate.markers.name_by_press import PressFit, disambiguate_by_press
from palpate.markers.name_markers import MarkerAssignment, assign_markers
from palpate.markers.pattern import MarkerPattern, build_pattern
from palpate.markers.rings import Rings, find_rings
from palpate.markers.spec import DetectSpec
from palpate.markers.tracker import Tracker, TrackState, find_markers
from palpate.markers.tracks import TrackedMarkers, Tracks

__all__ = [
    "Blobs",
    "DetectSpec",
    "Detector",
    "MarkerAssignment",
    "MarkerPattern",
    "MotionModel",
    "PressFit",
    "Rings",
    "TrackState",
    "TrackedMarkers",
    "Tracker",
    "Tracks",
    "assign_markers",
    "build_pattern",
    "disambiguate_by_press",
    "find_markers",
    "find_rings",
    "fit_motion_model",
    "prepare_detector",
]
