"""How deep a wall may be pressed: until the twin's force reaches the limit, or the twin's range ends."""

from __future__ import annotations

import numpy as np

from palpate.built import PoseFit, PoseFitter
from palpate.core import FloatArray, PalpateError
from palpate.design import wall_normal

_SIGMAS = 3.0
"""Standard deviations of force and depth that are kept from the limit."""
_SHARE = 0.01
"""What the twin's force is off of a unit whose stiffness is known, as in `palpate.built.force`."""
_UNSEEN_MM = 0.5
"""Depth at which dots may still be taken for untouched (`SensorSpec.touch_px`)."""
_BISECTIONS = 20
_MARGIN_MM = 0.2
"""Distance kept from the end of the twin's depths."""


class ForceLimit:
    """Depths at which a unit stays below a force.

    Parameters
    ----------
    fitter
        What reads the unit: its twin and stiffness.
    most_n
        Force along the normal that is never passed.
    depth_sd
        Standard deviation of a depth that is gone to, mm.
    """

    def __init__(self, fitter: PoseFitter, most_n: float, depth_sd: float) -> None:
        self._fitter, self._most, self._beyond = fitter, most_n, _SIGMAS * depth_sd

    def max_force(self, theta: FloatArray, depth: float) -> float:
        """Greatest force along the normal at a depth (mm), N; `theta` is that of a `PoseFit`."""
        scale = self._fitter.scale
        assert scale is not None
        pose = np.array([theta[0], theta[1], max(depth, 0.0)])
        looked = self._fitter.model.predict(pose, float(theta[3]), curvature=float(theta[4]), unit=False)
        pressing = max(float(looked.force @ wall_normal(*np.radians(pose[:2]))), 0.0)
        return pressing * (scale.mean + _SIGMAS * float(np.hypot(scale.sd, _SHARE * scale.mean)))

    def max_depth(self, fit: PoseFit, wanted: float) -> float:
        """The depth nearest to a wanted one (mm) at which the limit is kept even where the robot goes too deep."""
        twin = self._fitter.model.dots.twin
        tilt = min(float(np.hypot(*fit.state[:2])), float(twin.tilts_deg[-1]))
        high, low = min(wanted, twin.max_depth(tilt, float(fit.state[3])) - _MARGIN_MM), 0.0
        if self.max_force(fit.state, high + self._beyond) <= self._most:
            return high
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            low, high = (
                (middle, high) if self.max_force(fit.state, middle + self._beyond) <= self._most else (low, middle)
            )
        return low

    def check_step(self, step: float) -> None:
        """Refuse a limit that a step (mm) from a touch too light to be seen could pass, with a `PalpateError`."""
        depth = step + _UNSEEN_MM
        force = self.max_force(np.zeros(8), depth + self._beyond)
        if force > self._most:
            raise PalpateError(
                f"The search may go {depth:g} mm deep, which makes up to {force:.3f} N, above {self._most:g} N.",
                "Make the steps of the search shorter, or the limit greater.",
                code="force-limit-passed",
            )
