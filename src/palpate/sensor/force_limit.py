"""Maximum depth of a press, limited by the twin's force or the twin's range."""

from __future__ import annotations

import numpy as np

from palpate.calibration import CONTACT_STATE, PoseFit, PoseFitter
from palpate.core import PalpateError
from palpate.core.state import State
from palpate.design import TILT_SPACE, wall_normal

_SIGMAS = 3.0
"""Safety margin of force and depth, in standard deviations. By hand."""
_SHARE = 0.01
"""Relative error of the twin's force for a unit of known stiffness, as in `palpate.calibration.force`."""
_UNSEEN_MM = 0.5
"""Maximum depth at which a contact may be undetected (`SensorSpec.touch_px`). By hand."""
_BISECTIONS = 20
"""Halvings of the sought depth: 10 mm are known to 1e-5 mm."""
_MARGIN_MM = 0.2
"""Margin to the end of the twin's depths. By hand."""


class ForceLimit:
    """Depths at which a unit stays below a force.

    The force along the normal stays below `most_n`; `depth_sd` is the standard deviation of the robot's depth, mm.
    """

    def __init__(self, fitter: PoseFitter, most_n: float, depth_sd: float) -> None:
        self._fitter, self._most, self._beyond = fitter, most_n, _SIGMAS * depth_sd

    def max_force(self, contact: State, depth: float) -> float:
        """Return the maximum normal force (N) at a depth (mm) of a contact as in `PoseFit`, with its margin."""
        scale = self._fitter.scale
        assert scale is not None
        pressed = contact.replace(depth_mm=max(depth, 0.0))
        looked = self._fitter.model.predict_contact(pressed, lateral=False, unit=False)
        pressing = max(float(looked.force @ wall_normal(*np.radians(pressed[TILT_SPACE.names[:2]]))), 0.0)
        return pressing * (scale.value + _SIGMAS * float(np.hypot(scale.sd, _SHARE * scale.value)))

    def max_depth(self, fit: PoseFit, wanted: float) -> float:
        """Return the depth (mm), at most `wanted`, that keeps the limit even if the robot goes too deep."""
        twin = self._fitter.model.marker_twin.twin
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
        """Raise a `PalpateError` if a step (mm) from an undetected contact could exceed the limit."""
        depth = step + _UNSEEN_MM
        force = self.max_force(State.zeros(CONTACT_STATE), depth + self._beyond)
        if force > self._most:
            raise PalpateError(
                f"The search may reach a depth of {depth:g} mm with up to {force:.3f} N, above {self._most:g} N.",
                "Shorten the steps of the search, or increase the limit.",
                code="force-limit-passed",
            )
