"""Markers: from images to dots, their numbers and their paths through a press."""

from palpate.markers.blobs import Blobs
from palpate.markers.detector import Detector, prepare_detector
from palpate.markers.motion import Motion, learn_motion
from palpate.markers.name_by_press import PressFit, name_by_press
from palpate.markers.name_markers import Naming, name_markers
from palpate.markers.pattern import MarkerPattern, build_pattern
from palpate.markers.rings import Rings, find_rings
from palpate.markers.spec import DetectSpec
from palpate.markers.tracker import Tracker, TrackState, find_markers
from palpate.markers.tracks import Sighting, Tracks

__all__ = [
    "Blobs",
    "DetectSpec",
    "Detector",
    "MarkerPattern",
    "Motion",
    "Naming",
    "PressFit",
    "Rings",
    "Sighting",
    "TrackState",
    "Tracker",
    "Tracks",
    "build_pattern",
    "find_markers",
    "find_rings",
    "learn_motion",
    "name_by_press",
    "name_markers",
    "prepare_detector",
]
