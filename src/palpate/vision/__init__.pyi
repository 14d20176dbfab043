"""Vision: markers in images, their assignment, their motion, and the pose of the camera."""

from palpate.vision.assign_images import AssignedMarkers, assign_images, choose_reference
from palpate.vision.assign_markers import MarkerAssignment, assign_markers
from palpate.vision.detector import Detector, prepare_detector
from palpate.vision.disambiguate_by_press import PressFit, disambiguate_by_press
from palpate.vision.match_markers import Correspondence, MarkerMatcher, MatchFault, marker_descriptor
from palpate.vision.motion import MotionModel, fit_motion_model
from palpate.vision.observed_layout import ObservedLayout, number_markers
from palpate.vision.pattern import MarkerPattern, build_pattern
from palpate.vision.print_distortion import PrintDistortion
from palpate.vision.register import Registration, register_dome
from palpate.vision.rings import Rings, find_rings
from palpate.vision.segment import Blobs
from palpate.vision.spec import DetectSpec
from palpate.vision.tracker import TrackedMarkers, Tracker, Tracks, TrackState, find_markers

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
