"""Prediction by an estimator's ONNX file in its runtime, without the training libraries."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import FloatArray, PalpateError, load_extra
from palpate.design import PoseSpace
from palpate.learn.force_graph import FORCE, FORCE_HALF_WIDTH
from palpate.learn.graph import open_session
from palpate.learn.interval import Prediction
from palpate.learn.interval_graph import HALF_WIDTH, OUT_OF_DISTRIBUTION, POSE
from palpate.learn.io import INPUT, check_format

_INTERVAL, _FORCES = (HALF_WIDTH, OUT_OF_DISTRIBUTION), (FORCE, FORCE_HALF_WIDTH)


@dataclass(frozen=True, eq=False)
class Predictor:
    """A model file opened for prediction on one core.

    Attributes
    ----------
    session
        The runtime that holds the model.
    markers
        Number of markers that it reads.
    level
        Share of true values that its intervals cover; `None` for a model without any.
    space
        Components of the estimated pose.
    forces
        Whether it predicts forces as well.
    """

    session: Any
    markers: int
    level: float | None
    space: PoseSpace
    forces: bool = False

    def predict(self, images_px: FloatArray) -> Prediction:
        """Estimate poses with half-widths and out-of-distribution flags.

        Parameters
        ----------
        images_px
            (n, m, 2) u and v of every marker, in the order of the model's ``marker_order_px``.

        Returns
        -------
        Prediction
            Half-widths are infinite, and no image is out of distribution, if the model has no interval.

        Raises
        ------
        PalpateError
            If the images have another number of markers.
        """
        if images_px.shape[1:] != (self.markers, 2):
            raise PalpateError(
                f"The images have markers of shape {images_px.shape[1:]}, the model reads {(self.markers, 2)}.",
                "Use the model of this marker layout.",
                code="model-marker-count",
            )
        wanted = [POSE, *(_INTERVAL if self.level is not None else ()), *(_FORCES if self.forces else ())]
        given = {INPUT: np.ascontiguousarray(images_px, dtype=float)}
        found = [part.astype(float) for part in self.session.run(wanted, given)]
        forces = (found[-2], found[-1]) if self.forces else (None, None)
        unknown = np.full(found[0].shape, np.inf), np.zeros(len(found[0]))
        half, outside = unknown if self.level is None else found[1:3]
        return Prediction(found[0], half, outside > 0, *forces, space=self.space)


def open_predictor(path: Path) -> Predictor:
    """Open a model written by `write_estimator`; needs neither torch nor onnx.

    Raises
    ------
    PalpateError
        If the file is not an estimator of this format.
    MissingExtraError
        If onnxruntime is not installed.
    """
    load_extra("onnxruntime", "predict")
    try:
        session = open_session(path.read_bytes())
        metadata = check_format(path, session.get_modelmeta().custom_metadata_map)
        markers = int(session.get_inputs()[0].shape[1])
        level = float(json.loads(metadata["interval"])["level"]) if "interval" in metadata else None
        space = PoseSpace.from_names(json.loads(metadata["outputs"]))
    except PalpateError:
        raise
    except Exception as error:  # the runtime raises errors of its own, without a common parent
        raise PalpateError(
            f"{path} is not an estimator.",
            "Give a twin (.h5) of `palpate calibration predict`, model.h5 of `palpate recording train`, or a network "
            "(.onnx) of `palpate study model`.",
            code="model-unreadable",
        ) from error
    return Predictor(session, markers, level, space, "forces" in metadata)
