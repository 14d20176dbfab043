"""Cameras by name."""

from __future__ import annotations

from palpate.camera.spec import CameraSpec
from palpate.core import PalpateError

_PRESETS = {"davis346": CameraSpec()}


def list_presets() -> tuple[str, ...]:
    """Names of the cameras that `preset` knows."""
    return tuple(_PRESETS)


def camera_preset(name: str) -> CameraSpec:
    """Spec of a camera by its name.

    Raises
    ------
    PalpateError
        If there is no such camera; the message lists those that are.
    """
    if name not in _PRESETS:
        raise PalpateError(
            f"There is no camera named {name!r}.", f"Take one of: {', '.join(_PRESETS)}.", code="camera-unknown"
        )
    return _PRESETS[name]
