"""Hold the flat branch against the noise of the mesh.

Past a travel of some thicknesses the flattened disc of a thin dome carries almost no contact pressure: some 7 Pa
at T = 2 mm, less than the mesh resolves at T = 1 mm. Quadrature points of the disc then lose contact here and
there, and a discrete dome falls inside out where the continuum would not. So the middle of the contact patch is
held by a weak spring that also pulls; the greatest tension it bears is recorded with every equilibrium, and the
flat branch counts as lost where that exceeds the solver's `adhesion` (silicone itself sticks far better).
"""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray

_SECTORS = 6
_MIDDLE = 0.9
"""Share of the patch's radius that is held; with less, points outside it leave and return without end at T = 1."""


def patch_middle(place: FloatArray, normal: FloatArray, touching: BoolArray) -> BoolArray:
    """Points in the middle of the contact patch.

    Parameters
    ----------
    place
        (n, 3) mm undeformed contact points.
    normal
        (3,) normal of the wall.
    touching
        (n,) bool, points in contact.

    Returns
    -------
    (n,) bool
        Points nearer to the patch's centre than nine tenths of the radius at which contact ends, in the direction
        where it ends soonest. Directions are folded about the tilt plane, so half and whole models agree.
    """
    if np.count_nonzero(touching) < 4 * _SECTORS:
        return np.zeros(len(place), bool)
    along = np.array([0.0, 1.0, 0.0]) - normal[1] * normal
    along /= np.linalg.norm(along)
    across = np.cross(normal, along)
    flat = np.column_stack([place @ along, np.abs(place @ across)])
    centre = np.array([flat[touching, 0].mean(), 0.0])
    arm = flat - centre
    radius = np.hypot(arm[:, 0], arm[:, 1])
    sector = np.minimum((np.arctan2(arm[:, 1], arm[:, 0]) / np.pi * _SECTORS).astype(int), _SECTORS - 1)
    reach = [radius[touching & (sector == k)].max(initial=0.0) for k in range(_SECTORS)]
    middle: BoolArray = (radius < _MIDDLE * min(reach)) & (place @ normal > 0)
    return middle
