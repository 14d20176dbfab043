"""Markers: from images to dots, their numbers and their paths through a press."""

from palpate.markers.blobs import Blobs
from palpate.markers.detector import Detector, prepare_detector
from palpate.markers.spec import DetectSpec

__all__ = ["Blobs", "DetectSpec", "Detector", "prepare_detector"]
