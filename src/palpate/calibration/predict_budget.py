"""Predicted error budget: the effect of each imperfection on the angles, from a design's twin alone.

Camera and print errors have almost no effect alone, since each is determined by the rest image if its counterpart is
nominal. Each imperfection is therefore also removed from the full set.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from palpate.calibration.deviation import IMPERFECTIONS
from palpate.calibration.predict_accuracy import AccuracySpec, predict_accuracy
from palpate.calibration.tolerance import ToleranceSpec
from palpate.camera import Camera
from palpate.design import MarkerLayout
from palpate.surrogate import Twin

_UNCHANGED = ("friction_min", "friction_max")
"""Fields that are not set to zero: friction is fitted in each image."""
_UNSEEN = ("modulus", "stiffening", "missing", "depth_zero", "friction_min")
"""Imperfections without effect on angles in the linear model of the pose fit."""


class PredictedCost(NamedTuple):
    """Effect of one imperfection on the angles.

    Attributes
    ----------
    name, words
        Field of `ToleranceSpec`, and label.
    tolerance
        Its size.
    alone_deg
        RMSE of rx and ry by it alone, without the part by noise.
    saved_deg
        Decrease of the RMSE without it, in squares: ``sqrt(all² - all without it²)``.
    """

    name: str
    words: str
    tolerance: float
    alone_deg: float
    saved_deg: float


def predict_budget(
    twin: Twin, layout: MarkerLayout, camera: Camera, tolerance: ToleranceSpec, spec: AccuracySpec | None = None
) -> tuple[PredictedCost, ...]:
    """Predict the effects of all imperfections, in descending order; parameters as for `predict_accuracy`.

    Returns
    -------
    tuple[PredictedCost, ...]
        First ``all`` and ``noise``, then one for each imperfection that is not zero.
    """
    spec = replace(spec or AccuracySpec(), calibration_presses=0)
    none = tolerance.model_copy(update={name: 0.0 for name in ToleranceSpec.model_fields if name not in _UNCHANGED})
    every, noise = (predict_accuracy(twin, layout, camera, each, spec).rmse_deg for each in (tolerance, none))
    found = []
    for item in IMPERFECTIONS:
        size = float(getattr(tolerance, item.name))
        if size and item.name not in _UNSEEN:
            alone = predict_accuracy(twin, layout, camera, none.model_copy(update={item.name: size}), spec).rmse_deg
            without = predict_accuracy(
                twin, layout, camera, tolerance.model_copy(update={item.name: 0.0}), spec
            ).rmse_deg
            found.append(PredictedCost(item.name, item.label, size, _beyond(alone, noise), _beyond(every, without)))
    found.sort(key=lambda cost: -cost.saved_deg)
    return (
        PredictedCost("all", "all imperfections", 1.0, every, every),
        PredictedCost("noise", "marker noise and twin error", spec.noise_px, noise, noise),
        *found,
    )


def _beyond(more: float, less: float) -> float:
    return float(np.sqrt(max(more**2 - less**2, 0.0)))
