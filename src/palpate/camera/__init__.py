"""Camera: from points in the dome's frame to pixels, and from pixels back to rays."""

from palpate.camera.build_camera import build_camera
from palpate.camera.camera import Camera
from palpate.camera.distortion import Distortion
from palpate.camera.preset import list_presets, preset
from palpate.camera.spec import CameraSpec

__all__ = ["Camera", "CameraSpec", "Distortion", "build_camera", "list_presets", "preset"]
