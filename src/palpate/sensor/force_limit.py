"""How deep a wall may be pressed: until the twin's force reaches the limit, or the twin's range ends."""

from __future__ import annotations

import numpy as np

from palpate.calibration import CONTACT_STATE, PoseFit, PoseFitter
from palpate.core import PalpateError
from palpate.core.state import State
from palpate.design import TILT_SPACE, wall_normal

_SIGMAS = 3.0
"""Standard deviations of force and depth that are kept from the limit."""
_SHARE = 0.01
"""What the twin's force is off of a unit whose stiffness is known, as in `palpate.calibration.force`."""
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

    def max_force(self, contact: State, depth: float) -> float:
        """Greatest force along the normal at a depth (mm), N, of a contact as in `PoseFit`."""
        scale = self._fitter.scale
        assert scale is not None
        pressed = contact.replace(depth_mm=max(depth, 0.0))
        looked = self._fitter.model.predict_contact(pressed, lateral=False, unit=False)
        pressing = max(float(looked.force @ wall_normal(*np.radians(pressed[TILT_SPACE.names[:2]]))), 0.0)
        return pressing * (scale.mean + _SIGMAS * float(np.hypot(scale.sd, _SHARE * scale.mean)))

    def max_depth(self, fit: PoseFit, wanted: float) -> float:
        """The depth nearest to a wanted one (mm) at which the limit is kept even where the robot goes too deep."""
        twin = self._fitter.model.dots.twin
        tilt = min(float(np.hypot(*fit.state[TILT_SPACE.names[:2]])), float(twin.tilts_deg[-1]))
        high, low = min(wanted, twin.max_depth(tilt, fit.state["inverse_friction"]) - _MARGIN_MM), 0.0
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
        force = self.max_force(State.zeros(CONTACT_STATE), depth + self._beyond)
        if force > self._most:
            raise PalpateError(
                f"The search may go {depth:g} mm deep, which makes up to {force:.3f} N, above {self._most:g} N.",
                "Make the steps of the search shorter, or the limit greater.",
                code="force-limit-passed",
            )
