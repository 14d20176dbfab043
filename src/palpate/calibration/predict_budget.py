"""Which imperfection costs how much, from a design's twin alone.

Camera and print cost next to nothing alone, for the rest image tells the one where the other is right; so each is
also taken away from all.
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
"""Fields that stay as they are: friction is fitted in each image."""
_UNSEEN = ("modulus", "stiffening", "missing", "depth_zero", "friction_min")
"""Imperfections that cost no angle in the model of a twin's fit."""


class PredictedCost(NamedTuple):
    """What one imperfection costs of angle.

    Attributes
    ----------
    name, words
        Field of `ToleranceSpec`, and what a person reads.
    tolerance
        Its size.
    alone_deg
        RMSE of rx and ry by it alone, beside what noise leaves.
    saved_deg
        By how much its absence would lower the RMSE, squares taken: ``sqrt(all² - all without it²)``.
    """

    name: str
    words: str
    tolerance: float
    alone_deg: float
    saved_deg: float


def predict_budget(
    twin: Twin, layout: MarkerLayout, camera: Camera, tolerance: ToleranceSpec, spec: AccuracySpec | None = None
) -> tuple[PredictedCost, ...]:
    """Costs of all imperfections, the greatest first.

    Parameters
    ----------
    twin, layout, camera, tolerance, spec
        As for `foresee`.

    Returns
    -------
    tuple[PredictedCost, ...]
        One an imperfection that is not zero, after those named ``all`` and ``noise``.
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
        PredictedCost("all", "everything together", 1.0, every, every),
        PredictedCost("noise", "noise of the dots, and the twin itself", spec.noise_px, noise, noise),
        *found,
    )


def _beyond(more: float, less: float) -> float:
    return float(np.sqrt(max(more**2 - less**2, 0.0)))
