"""An estimator at work: the ONNX file in a runtime of its own, without what trained it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import MissingExtraError, PalpateError
from palpate.learn.io import AGAIN, INPUT, POSE, check_format

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Predictor:
    """A model file opened for prediction on one core.

    Attributes
    ----------
    session
        The runtime that holds the model.
    markers
        Number of markers that it reads.
    """

    session: Any
    markers: int

    def predict(self, images_px: Array) -> Array:
        """Estimate poses.

        Parameters
        ----------
        images_px
            (n, m, 2) u and v of every marker, in the order of the model's ``marker_order_px``.

        Returns
        -------
        Array
            (n, 3): rx and ry (degrees), depth (mm).

        Raises
        ------
        PalpateError
            If the images have another number of markers.
        """
        if images_px.shape[1:] != (self.markers, 2):
            raise PalpateError(
                f"The images have markers of shape {images_px.shape[1:]}, the model reads {(self.markers, 2)}.",
                "Use the model of this marker layout.",
            )
        poses: Array = self.session.run([POSE], {INPUT: np.ascontiguousarray(images_px, dtype=float)})[0]
        return poses.astype(float)


def open_predictor(path: Path) -> Predictor:
    """Open a model written by `write_estimator`; needs neither torch nor onnx.

    Raises
    ------
    PalpateError
        If the file is not an estimator of this format.
    MissingExtraError
        If onnxruntime is not installed.
    """
    try:
        import onnxruntime
    except ImportError as error:
        raise MissingExtraError("onnxruntime", "predict") from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4  # what is wrong is said below, once
    try:
        session = onnxruntime.InferenceSession(path.read_bytes(), options, providers=["CPUExecutionProvider"])
        check_format(path, session.get_modelmeta().custom_metadata_map)
        markers = int(session.get_inputs()[0].shape[1])
    except PalpateError:
        raise
    except Exception as error:  # the runtime raises errors of its own, without a common parent
        raise PalpateError(f"{path} is not an estimator: {type(error).__name__}.", AGAIN) from error
    return Predictor(session, markers)
