"""Automatic controls of a camera, by V4L2 or OpenCV, and the commands that switch them off."""

from __future__ import annotations

import re
import shutil
import subprocess
from contextlib import suppress

from palpate.camera import Source
from palpate.rig.check_camera import CameraFigure

_MANUAL = {
    "auto_exposure": 1,
    "exposure_auto": 1,
    "exposure_dynamic_framerate": 0,
    "exposure_auto_priority": 0,
    "white_balance_automatic": 0,
    "white_balance_temperature_auto": 0,
    "focus_automatic_continuous": 0,
    "focus_auto": 0,
    "gain_automatic": 0,
    "autogain": 0,
}
"""V4L2 control, by its new and old name → value of its manual mode, as in the Linux kernel."""
_CONTROL = re.compile(r"^\s*(\w+) (?:0x[0-9a-f]+ )?\(\w+\)\s*:.*\bvalue=(-?\d+)", re.MULTILINE)
"""A line of ``v4l2-ctl --list-ctrls``."""


def find_automatic_controls(source: Source, timeout_s: float = 10.0) -> list[CameraFigure]:
    """Compare the controls of a live camera with those of fixed settings; unknown controls are left out.

    They are those of the program `v4l2-ctl`, or of OpenCV if it is missing. No control is changed.
    """
    if not source.device:
        return []
    controls = dict(source.controls)
    if program := shutil.which("v4l2-ctl"):
        with suppress(OSError, subprocess.TimeoutExpired):
            words = [program, "-d", source.device, "--list-ctrls"]
            done = subprocess.run(words, capture_output=True, text=True, timeout=timeout_s, check=False)
            controls = {name: float(value) for name, value in _CONTROL.findall(done.stdout)} or controls
    return [
        CameraFigure(
            name,
            "automatic control of the camera",
            controls[name],
            off,
            "1",
            controls[name] == off,
            f"Switch it off: `v4l2-ctl -d {source.device} -c {name}={off}`.",
        )
        for name, off in _MANUAL.items()
        if name in controls
    ]
