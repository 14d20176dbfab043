"""How far dots are from where a model has them: noise of the detector, what the twin is off, false dots."""

from __future__ import annotations

import numpy as np

from palpate.camera import Camera, flat_marker_outlines, project_markers
from palpate.core import FloatArray
from palpate.design import MarkerLayout, Skin

NOISE_PX = 0.02
"""Standard deviation of a dot's coordinate in an image of 346 x 260 px, as the detector finds it on the bench."""
NOISE_DOT_PX = 4.4
"""Diameter in the image of the dot that has it: 1 mm on H20, 48 mm before the camera."""
_GRAIN = 0.865
"""Share of its variance by the noise of pixels, over the root of the diameter as the Cramer-Rao bound says; the rest
grows with the diameter, by light that is uneven across a dot. From `benchmarks/dot_noise.py`: 24 diameters of 3.2
to
15.5 px on degraded images of the bench, within 19 % of the law (docs/design_notes/calibration.md)."""
MODEL_ERROR_PX = 0.02
"""What the twin itself may be off, px, of a skin and in an image of the sizes in `palpate.calibration.scale`."""
FREEDOM = 30.0
"""Degrees of freedom of Student's distribution, of dots that are not where they should be."""
_MEDIAN = 2.0 * np.log(2.0)
"""Median square of two normal numbers together."""


def noise_by_diameter(diameter_px: FloatArray, noise_px: float = NOISE_PX) -> FloatArray:
    """Standard deviations of a coordinate of dots that are so wide in the image, px.

    Parameters
    ----------
    diameter_px
        (m,) as from `palpate.camera.project_markers`.
    noise_px
        Of a dot of `NOISE_DOT_PX`.

    Examples
    --------
    >>> noise_by_diameter(np.array([2.2, 4.4, 8.8])).round(4).tolist()
    [0.0266, 0.02, 0.0197]
    """
    share = diameter_px / NOISE_DOT_PX
    return np.asarray(noise_px * np.sqrt(_GRAIN / share + (1.0 - _GRAIN) * share**2), float)


def layout_noise(skin: Skin, layout: MarkerLayout, camera: Camera, noise_px: float = NOISE_PX) -> FloatArray:
    """Standard deviations (m,) px of a coordinate of a layout's dots, by their size in the image at rest."""
    edges = flat_marker_outlines(layout.positions, skin.normal(layout.positions), layout.diameter)
    return noise_by_diameter(project_markers(camera, edges).diameters, noise_px)


def robust_weights(left: FloatArray, variance: float | FloatArray) -> FloatArray:
    """Weights (2 n,) of coordinates over their variance, by Student's distribution: less for dots that fit badly.

    The variance, px², is that of all dots, or (n,) of each.

    Where most dots fit badly, as at the beginning of an iteration, what is bad is measured by the median of them.
    """
    far = (left.reshape(-1, 2) ** 2).sum(axis=1) / variance
    scale = max(1.0, float(np.median(far)) / _MEDIAN) if len(far) else 1.0
    return np.repeat((FREEDOM + 2.0) / (FREEDOM + far / scale) / variance, 2)
