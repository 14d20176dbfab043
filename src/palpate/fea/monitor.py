"""Monitor of a press: branch of a state, contact stabilisation, and end criteria.

*Contact stabilisation.* Beyond a depth of some thicknesses, the flattened disc of a thin skin has almost no contact
pressure: some 7 Pa at T = 2 mm, less than the mesh resolves at T = 1 mm. Quadrature points of the disc then lose
contact, and the discrete skin inverts where the continuum would not. The middle of the contact patch is therefore
held by a weak spring that also pulls, except over a hole. Its maximum tension is recorded with every equilibrium. The
flat branch counts as lost if this exceeds the solver's `adhesion` (silicone itself adheres much more strongly).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.mechanics import ContactLoading, EndReason, Monitor, Solid, State, smallest_stretch

SECTORS = 6
"""Sectors of half a turn: in each, the radius of a patch is measured, and a ring must touch. By hand."""
_MIDDLE = 0.9
"""Share of the patch's radius that is stabilised.

With a smaller share, points outside it leave and return without end at T = 1. By hand.
"""
INVERTED_GAP = 0.1
"""Gap of the first-contact point over the thickness above which the apex counts as inverted.

It is some micrometres on the flat branch. By hand.
"""
_PULL, _PULL_FROM = 0.01, 1.5
"""Stabilising spring over the contact penalty, and the depth over the thickness above which it acts.
From half this depth it keeps a thin dome from inverting: 180 % of force. By hand."""
_FOLDING_STRETCH = 0.647
"""Stretch below which a free surface under plane strain compression creases (Hong, Zhao & Suo 2009).

A smooth surface is unstable below 0.544 (Biot 1963). The loss of a branch below this stretch is attributed to a fold.
"""
_STEEP = 0.999
"""Component of a normal along y above which y defines no direction across it."""
_SHALLOW = 1.0
"""Depth (mm, times the unit) below which the width of a perturbation is constant. By hand."""


@final
@dataclass(frozen=True)
class SkinMonitor(Monitor):
    """Monitor of a skin over a base plane, pressed from above.

    Attributes
    ----------
    solid
        The skin.
    loading
        The obstacle and the skin's outer surface.
    probe
        First-contact point; its gap determines the branch.
    normal
        (3,) normal of the obstacle there.
    thickness
        mm.
    unit
        Factor on lengths, as in `palpate.mechanics.continuation`.
    centre
        (3,) mm, undeformed centre of the contact patch if known by symmetry; else it is the mean of the points.
    """

    solid: Solid
    loading: ContactLoading
    probe: int
    normal: FloatArray
    thickness: float
    unit: float
    centre: FloatArray | None = None

    @property
    def modulus(self) -> float:  # type: ignore[override]
        return self.solid.material.young_modulus

    @property
    def area(self) -> float:  # type: ignore[override]
        return self.loading.surface.area

    @property
    def axes(self) -> tuple[FloatArray, FloatArray]:
        """Unit vectors (3,) across the normal: in the tilt plane, and out of it."""
        along = tilt_way(self.normal)
        return along, np.cross(self.normal, along)

    def gap(self, at: float, state: State) -> float:
        """Return the distance in mm between the obstacle at a depth and the first-contact point."""
        met = self.loading.contact_pair(at, state)
        return -float(met.obstacle.depth_below(met.points[self.probe : self.probe + 1])[0])

    def inverted(self, at: float, state: State) -> bool:
        return self.gap(at, state) > INVERTED_GAP * self.thickness

    def stabilisation(self, at: float, state: State) -> FloatArray | None:
        if at <= _PULL_FROM * self.thickness:
            return None
        middle = patch_middle(self.loading.surface.points, self.normal, self.loading.touching(at, state), self.centre)
        met = self.loading.contact_pair(at, state)
        over_hole = met.obstacle.depth_below(met.points) > met.obstacle.penetration(met.points)
        return np.where(middle & ~over_hole, _PULL * self.loading.law.stiffness, 0.0)

    def tension(self, at: float, state: State, springs: FloatArray) -> float:
        lift = -self.loading.penetration(at, state)
        return float((springs * np.maximum(lift, 0.0)).max(initial=0.0))

    def perturbed(self, at: float, state: State, push: float) -> FloatArray:
        """Add a dent at the first-contact point, as wide as a contact ring at this depth."""
        touched = self.loading.surface.points[self.probe]
        away = np.linalg.norm(self.solid.nodes - touched, axis=1)
        width = np.sqrt(max(at, _SHALLOW * self.unit) * np.linalg.norm(touched)) / 2
        dented: FloatArray = state.u - push * np.exp(-((away / width) ** 2))[:, None] * self.normal
        return dented

    def fault(self, state: State) -> tuple[EndReason, str] | None:
        """Report silicone that is compressed so much that its free surface folds."""
        stretch, place = smallest_stretch(self.solid, state)
        if stretch >= _FOLDING_STRETCH:
            return None
        where = ", ".join(f"{value:.1f}" for value in place)
        return (
            EndReason.FOLDED,
            f"where the silicone at ({where}) mm is compressed to {stretch:.2f} of its length: below "
            f"{_FOLDING_STRETCH:g} a free surface folds",
        )


def tilt_way(normal: FloatArray) -> FloatArray:
    """Return the unit vector (3,) across a normal (3,) in the tilt plane, closest to y (side wall: z)."""
    steep = abs(normal[1]) > _STEEP
    along = (
        np.array([0.0, 0.0, 1.0]) - normal[2] * normal if steep else np.array([0.0, 1.0, 0.0]) - normal[1] * normal
    )
    return np.asarray(along / np.linalg.norm(along))


def patch_middle(
    place: FloatArray, normal: FloatArray, touching: BoolArray, centre: FloatArray | None = None
) -> BoolArray:
    """Return the (n,) contact points, undeformed at `place` (n, 3) mm, in the middle of the contact patch.

    These are the points within 90 % of the radius of contact about the centre, in the direction of its smallest
    radius. Directions are folded about the tilt plane, so half and whole models agree. Without a `centre` (3,) mm it
    is the mean of the points `touching` along the tilt.
    """
    if np.count_nonzero(touching) < 4 * SECTORS:
        return np.zeros(len(place), bool)
    along = tilt_way(normal)
    across = np.cross(normal, along)
    flat = np.column_stack([place @ along, np.abs(place @ across)])
    arm = flat - np.array([flat[touching, 0].mean() if centre is None else centre @ along, 0.0])
    radius = np.hypot(arm[:, 0], arm[:, 1])
    sector = np.minimum((np.arctan2(arm[:, 1], arm[:, 0]) / np.pi * SECTORS).astype(int), SECTORS - 1)
    there = [k for k in range(SECTORS) if (sector == k).any()]  # a quarter model has no other sectors
    reach = [radius[touching & (sector == k)].max(initial=0.0) for k in there]
    middle: BoolArray = (radius < _MIDDLE * min(reach)) & (place @ normal > 0)
    return middle
