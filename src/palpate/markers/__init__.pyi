"""Vision: markers in images, their assignment, their motion, and the pose of the camera."""

from palpate.markers.assign_images import AssignedMarkers, assign_images, choose_reference
from palpate.markers.detector import Detector, prepare_detector
from palpate.markers.match_markers import Correspondence, MarkerMatcher, MatchFault, marker_descriptor
from palpate.markers.motion import MotionModel, fit_motion_model
from palpate.markers.name_by_press import PressFit, disambiguate_by_press
from palpate.markers.name_markers import MarkerAssignment, assign_markers
from palpate.markers.observed_layout import ObservedLayout, number_markers
from palpate.markers.pattern import MarkerPattern, build_pattern
from palpate.markers.print_distortion import PrintDistortion
from palpate.markers.register import Registration, register_dome
from palpate.markers.rings import Rings, find_rings
from palpate.markers.segment import Blobs
from palpate.markers.spec import DetectSpec
from palpate.markers.tracker import TrackedMarkers, Tracker, Tracks, TrackState, find_markers

__all__ = [
    "AssignedMarkers",
    "Blobs",
    "Correspondence",
    "DetectSpec",
    "Detector",
    "MarkerAssignment",
    "MarkerMatcher",
    "MarkerPattern",
    "MatchFault",
    "MotionModel",
    "ObservedLayout",
    "PressFit",
    "PrintDistortion",
    "Registration",
    "Rings",
    "TrackState",
    "TrackedMarkers",
    "Tracker",
    "Tracks",
    "assign_images",
    "assign_markers",
    "build_pattern",
    "choose_reference",
    "disambiguate_by_press",
    "find_markers",
    "find_rings",
    "fit_motion_model",
    "marker_descriptor",
    "number_markers",
    "prepare_detector",
    "register_dome",
]
