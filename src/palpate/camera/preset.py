"""Cameras by name."""

from __future__ import annotations

from palpate.camera.spec import CameraSpec
from palpate.core import PalpateError

_PRESETS = {"davis346": CameraSpec()}


def list_presets() -> tuple[str, ...]:
    """Return the names of the cameras that `camera_preset` knows."""
    return tuple(_PRESETS)


def camera_preset(name: str) -> CameraSpec:
    """Return the spec of a camera by its name.

    Raises
    ------
    PalpateError
        If the camera is unknown; the message lists the known ones.
    """
    if name not in _PRESETS:
        raise PalpateError(
            f"Unknown camera {name!r}.", f"Choose one of: {', '.join(_PRESETS)}.", code="camera-unknown"
        )
    return _PRESETS[name]
