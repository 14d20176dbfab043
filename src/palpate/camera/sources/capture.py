"""Videos and cameras opened by OpenCV."""

from __future__ import annotations

from typing import Any

from palpate.camera.read_image import LARGEST_MPX
from palpate.core import PalpateError, load_opencv


def open_capture(what: str | int) -> Any:
    """Open a video or camera by OpenCV, with its size checked before an image is decoded.

    Raises
    ------
    PalpateError
        If it cannot be opened, or its images are too large.
    """
    cv2 = load_opencv()
    capture = cv2.VideoCapture(what)
    if not capture.isOpened():
        known = f"camera {what}" if isinstance(what, int) else what
        raise PalpateError(
            f"{known} cannot be opened.",
            "Connect it and close other programs that use it. `--source synthetic` is a simulated sensor."
            if isinstance(what, int)
            else "Check the file: it is damaged, or has a format that this OpenCV does not read.",
            code="source-not-opened",
        )
    width, height = capture.get(cv2.CAP_PROP_FRAME_WIDTH), capture.get(cv2.CAP_PROP_FRAME_HEIGHT)
    if width * height > LARGEST_MPX * 1e6:
        capture.release()
        raise PalpateError(
            f"{what} has {width:.0f} × {height:.0f} px, more than {LARGEST_MPX:g} million.",
            "Reduce the size of its images.",
            code="image-too-large",
        )
    return capture
