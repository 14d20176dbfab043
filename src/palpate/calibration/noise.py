"""Marker residuals: detector noise, twin error, and robust weights for false detections."""

from __future__ import annotations

import numpy as np

from palpate.camera import Camera, flat_marker_outlines, project_markers
from palpate.core import FloatArray
from palpate.design import MarkerLayout, Skin

NOISE_PX = 0.02
"""Standard deviation of a marker coordinate of the detector in simulated images of 346 x 260 px."""
NOISE_DOT_PX = 4.4
"""Marker diameter in the image for `NOISE_PX`: 1 mm on H20, 48 mm before the camera."""
_GRAIN = 0.865
"""Share of the variance by pixel noise, inverse to the diameter as in the Cramér-Rao bound.

The rest grows with the square of the diameter, by uneven light across a marker. From `benchmarks/dot_noise.py`: 24
diameters from 3.2 to 15.5 px on degraded simulated images, within 19 % of this law
(docs/design_notes/calibration.md).
"""
MODEL_ERROR_PX = 0.02
"""Twin error of a marker, px, for skin and image of the sizes in `palpate.calibration.scale`. By hand."""
FREEDOM = 30.0
"""Degrees of freedom of Student's distribution of the residuals. By hand."""
_MEDIAN = 2.0 * np.log(2.0)
"""Median of the sum of two squared standard normal numbers."""


def noise_by_diameter(diameter_px: FloatArray, noise_px: float = NOISE_PX) -> FloatArray:
    """Return the standard deviations (m,) px of a marker coordinate, by marker diameter (m,) px.

    Parameters
    ----------
    diameter_px
        (m,) as from `palpate.camera.project_markers`.
    noise_px
        Standard deviation of a marker of diameter `NOISE_DOT_PX`.

    Examples
    --------
    >>> noise_by_diameter(np.array([2.2, 4.4, 8.8])).round(4).tolist()
    [0.0266, 0.02, 0.0197]
    """
    share = diameter_px / NOISE_DOT_PX
    return np.asarray(noise_px * np.sqrt(_GRAIN / share + (1.0 - _GRAIN) * share**2), float)


def layout_noise(skin: Skin, layout: MarkerLayout, camera: Camera, noise_px: float = NOISE_PX) -> FloatArray:
    """Return the standard deviations (m,) px of a marker coordinate, by marker size in the rest image."""
    edges = flat_marker_outlines(layout.positions, skin.normal(layout.positions), layout.diameter)
    return noise_by_diameter(project_markers(camera, edges).diameters, noise_px)


def robust_weights(left: FloatArray, variance: float | FloatArray) -> FloatArray:
    """Return weights (2 n,) of coordinates by Student's distribution, over their variance (px²; or (n,)).

    Residuals are scaled by their median if most markers fit badly, as in the first iterations.
    """
    far = (left.reshape(-1, 2) ** 2).sum(axis=1) / variance
    scale = max(1.0, float(np.median(far)) / _MEDIAN) if len(far) else 1.0
    return np.repeat((FREEDOM + 2.0) / (FREEDOM + far / scale) / variance, 2)
