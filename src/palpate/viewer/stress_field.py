"""Von Mises stress at the nodes of every solved press of a dome."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from palpate.fea import Press, nodal_von_mises
from palpate.viewer.pressed_dome import Array32, PressedDome, match_depths


def find_stress(pressed: PressedDome, presses: Sequence[Press]) -> Array32:
    """Von Mises Cauchy stress (d, t, n, 1) in MPa of the presses of a dome; zero where one ended before, or at rest.

    It is interpolated between tilts like the displacement, which costs less than finding it again from there.
    """
    found = np.zeros((*pressed.displacement.shape[:3], 1), np.float32)
    for tilt, press in enumerate(sorted(presses, key=lambda press: press.wall.radial)):
        depth, image = match_depths(pressed.depths_mm, press)
        found[depth, tilt, :, 0] = np.nan_to_num(nodal_von_mises(press)[image])
    return found
