"""Camera: from points in the dome's frame to pixels and back to rays; the lens from images of a board."""

from palpate.camera.board import BoardSpec, CalibrationSpec, read_board
from palpate.camera.build_camera import build_camera
from palpate.camera.calibrate import calibrate_camera
from palpate.camera.calibration import Calibration
from palpate.camera.calibration_file import read_calibration, write_calibration
from palpate.camera.camera import Camera
from palpate.camera.draw_board import write_board
from palpate.camera.lens import LENSES, Lens
from palpate.camera.marker_traces import flat_marker_outlines, marker_outlines, project_markers, tangent_pair
from palpate.camera.preset import camera_preset, list_presets
from palpate.camera.read_image import LARGEST_MPX, decode_image, list_images, read_image
from palpate.camera.read_image import SUFFIXES as IMAGE_SUFFIXES
from palpate.camera.render import RenderSpec, render
from palpate.camera.source import SOURCES, Source, open_source, recording_suffixes
from palpate.camera.spec import CameraSpec
from palpate.camera.window import Window, WindowSpec, read_window

__all__ = [
    "IMAGE_SUFFIXES",
    "LARGEST_MPX",
    "LENSES",
    "SOURCES",
    "BoardSpec",
    "Calibration",
    "CalibrationSpec",
    "Camera",
    "CameraSpec",
    "Lens",
    "RenderSpec",
    "Source",
    "Window",
    "WindowSpec",
    "build_camera",
    "calibrate_camera",
    "camera_preset",
    "decode_image",
    "flat_marker_outlines",
    "list_images",
    "list_presets",
    "marker_outlines",
    "open_source",
    "project_markers",
    "read_board",
    "read_calibration",
    "read_image",
    "read_window",
    "recording_suffixes",
    "render",
    "tangent_pair",
    "write_board",
    "write_calibration",
]
