"""Flat window between camera and skin, and gel behind it: refraction of lines of sight at two planes.

The window fills ``-t <= z <= 0`` of the skin's frame; air is below it, and gel or air between window and markers
above. By Snell's law ``n_i sin θ_i`` is equal in all three layers, so a line of sight of slope ``p = tan θ`` in air
has, in a layer of index n_i, the slope

    g_i(p) = p / √(n_i² + (n_i² - 1) p²)

and a point at the distance ρ from the pinhole's vertical is seen at the p with

    Σ h_i g_i(p) = ρ,    h_i the height of the path in air, window and gel.

Since no index is less than that of air, the sum is concave and grows with p. Newton's iteration from below, from the
paraxial ``ρ / Σ h_i / n_i``, converges to the single root. Max Born & Emil Wolf, *Principles of Optics*, 7th ed.
1999, 3.2.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError

from palpate.camera.arrays import array_module, as_array
from palpate.core import FloatArray, PalpateError, Spec, parameter

_ITERATIONS = 60
"""Maximum number of iterations."""
_TOLERANCE = 1e-14
"""Relative change of the slope at which the iteration ends, in double precision."""
_ROUNDING = 4.0
"""Relative change of the slope at which it ends in single precision, over the rounding error."""


class WindowSpec(Spec):
    """A flat window in the base plane, and the medium behind it."""

    thickness: float = parameter(2.0, unit="mm", meaning="thickness of the window", ge=0, le=50)
    index: float = parameter(
        1.49, unit="1", meaning="refractive index of the window", source="acrylic; glass: 1.52", ge=1, le=2.5
    )
    gel_index: float = parameter(
        1.41,
        unit="1",
        meaning="refractive index of the medium between window and markers; 1 for air",
        source="clear silicone",
        ge=1,
        le=2.5,
    )


def read_window(text: str) -> WindowSpec:
    """Read a window from text, ``THICKNESS``, ``THICKNESS,INDEX`` or ``THICKNESS,INDEX,GEL_INDEX``.

    Raises
    ------
    PalpateError
        If the text has another form, or a number is out of bounds.

    Examples
    --------
    >>> read_window("3,1.52").index
    1.52
    """
    names, values = list(WindowSpec.model_fields), text.split(",")
    why = f"it has {len(values)} numbers" if len(values) > len(names) else ""
    try:
        window = WindowSpec.model_validate(dict(zip(names, values, strict=False)))
    except ValidationError as error:
        why = "; ".join(f"{item['loc'][0]}: {item['msg']}" for item in error.errors())
    if why:
        raise PalpateError(
            f"'{text}' is not a window: {why}.",
            "Write THICKNESS,INDEX,GEL_INDEX such as 2,1.49,1.41: mm, and the refractive indices of window and gel.",
            code="window-malformed",
        )
    return window


@dataclass(frozen=True)
class Window:
    """Refraction by a window: its `thickness` in mm, refractive indices of window and medium behind it."""

    thickness: float
    index: float
    gel_index: float

    def aim(self, origin: FloatArray, points: FloatArray) -> FloatArray:
        """Return the vectors along which a pinhole sees points (..., 3) mm behind the window.

        Each vector (..., 3) mm has the direction of the line of sight in air, and the height of the point above the
        pinhole `origin` (3,) mm, which is in air below the window. For a point that is not above the pinhole, it is
        the vector to the point.
        """
        module = array_module(points)
        arm = points - as_array(origin, points)
        rise = module.where(arm[..., 2] > 0.0, arm[..., 2], np.nan)
        # on the axis neither slope nor distance has a direction, and torch no derivative of the distance
        aside = (arm[..., 0] != 0.0) | (arm[..., 1] != 0.0)
        reach = module.where(aside, module.hypot(module.where(aside, arm[..., 0], 1.0), arm[..., 1]), 0.0)
        heights = self.heights(float(origin[2]), points[..., 2])
        indices = 1.0, self.index, self.gel_index
        with np.errstate(divide="ignore", invalid="ignore"):
            slope, paraxial = _solve(heights, indices, reach), 1.0 / _apparent(heights, indices)
        # the slope over the distance has a limit on the axis
        steep = module.where(aside, slope / module.where(aside, reach, 1.0), paraxial)
        seen = module.concatenate([arm[..., :2] * (steep * rise)[..., None], rise[..., None]], axis=-1)
        return module.where(module.isfinite(rise)[..., None], seen, arm)

    def enter(self, origin: FloatArray, rays: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lines of sight behind the window.

        Parameters
        ----------
        origin
            (3,) mm the pinhole, in air below the window.
        rays
            (..., 3) directions in air; those that do not rise to the window result in NaN.

        Returns
        -------
        starts
            (..., 3) mm, their points on the upper side of the window, in the base plane.
        rays
            (..., 3) unit vectors.
        """
        up = np.where(rays[..., 2] > 0.0, rays[..., 2], np.nan)
        across = rays[..., :2] / up[..., None]
        slope = np.linalg.norm(across, axis=-1)
        air, window, _ = self.heights(float(origin[2]), np.zeros_like(slope))
        carried = air + window * _distort(slope, self.index)
        starts = np.zeros(rays.shape)
        starts[..., :2] = origin[:2] + across * carried[..., None]
        starts[..., 2] = np.where(np.isnan(up), np.nan, 0.0)
        behind = np.ones(rays.shape)
        behind[..., :2] = across * _distort(slope, self.gel_index)[..., None]
        return starts, behind / np.linalg.norm(behind, axis=-1, keepdims=True)

    def heights(self, origin_z: float, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the heights (...) mm of the paths in air, window and gel to points at z (...) mm."""
        clip = array_module(z).clip
        air = clip(z - origin_z, 0.0, -self.thickness - origin_z)
        return air, clip(z + self.thickness, 0.0, self.thickness), clip(z, 0.0, None)


Layers = tuple[FloatArray, FloatArray, FloatArray]


def _distort(slope: FloatArray, index: float) -> FloatArray:
    """Return the slope in a layer over that in air."""
    over: FloatArray = 1.0 / array_module(slope).sqrt(index**2 + (index**2 - 1.0) * slope**2)
    return over


def _apparent(heights: Layers, indices: tuple[float, float, float]) -> FloatArray:
    """Return the apparent height of a point near the axis."""
    found: Any = sum(height / index for height, index in zip(heights, indices, strict=True))
    return found


def _solve(heights: Layers, indices: tuple[float, float, float], reach: FloatArray) -> FloatArray:
    """Return the slopes in air of lines of sight to points `reach` (...) mm from the axis, or NaN."""
    module, slope = array_module(reach), reach / _apparent(heights, indices)
    tolerance = max(_TOLERANCE, _ROUNDING * module.finfo(slope.dtype).eps)
    for _ in range(_ITERATIONS):
        ways = [(h, index**2, _distort(slope, index)) for h, index in zip(heights, indices, strict=True)]
        miss = reach - slope * sum(h * bend for h, _, bend in ways)
        step = miss / sum(h * square * bend**3 for h, square, bend in ways)
        slope = slope + step
        if not module.any(module.abs(step) > tolerance * (1.0 + slope)):
            break
    return slope
