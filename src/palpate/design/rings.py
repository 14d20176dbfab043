"""Rings of markers: one at the apex, then 6, 12, 18, … in rings about it.

n rings hold 1 + 6 + 12 + … + 6 n = 1 + 3 n (n + 1) markers: 7, 19, 37, 61, 91, 127, 169, …
"""

from __future__ import annotations

from palpate.core import PalpateError

MAX_RINGS = 20
"""More rings than this no camera of today resolves."""

OUTERMOST = 0.875
"""Diameter of the outermost ring over the base diameter where no preset gives it (169 markers: 35/40)."""

PRESET_BASE_RADIUS = 20.0
"""Base radius that `PRESET_DIAMETERS` belong to, mm."""

PRESET_DIAMETERS: dict[int, tuple[float, ...]] = {
    7: (18.0,),
    37: (10.0, 20.0, 30.0),
    91: (6.0, 12.0, 18.0, 24.0, 30.0),
    169: (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0),
}
"""Ring diameters projected on the base plane, mm, by number of markers; from the published simulations of
Zaid et al. 2024 (`palpate.core.PAPER`)."""


def markers_in_rings(rings: int) -> int:
    """Number of markers of `rings` rings and the one at the apex: 1 + 3 n (n + 1)."""
    return 1 + 3 * rings * (rings + 1)


def ring_count(count: int) -> int | None:
    """Number of rings that hold `count` markers, or `None` where no full set of rings does."""
    for rings in range(MAX_RINGS + 1):
        if markers_in_rings(rings) == count:
            return rings
    return None


def ring_diameters(count: int, base_radius: float = PRESET_BASE_RADIUS) -> tuple[float, ...]:
    """Ring diameters of `count` markers, from the apex outward.

    A preset is scaled with the base radius; any other number of rings is spaced evenly up to 0.875 of the
    base diameter.

    Parameters
    ----------
    count
        Number of markers, 1 + 3 n (n + 1).
    base_radius
        Radius of the inner surface's rim, mm.

    Returns
    -------
    tuple of float
        Diameters projected on the base plane, mm.

    Raises
    ------
    PalpateError
        If `count` is not a ring number.

    Examples
    --------
    >>> ring_diameters(37)
    (10.0, 20.0, 30.0)
    >>> ring_diameters(37, base_radius=10)
    (5.0, 10.0, 15.0)
    """
    if count in PRESET_DIAMETERS:
        scale = base_radius / PRESET_BASE_RADIUS
        return tuple(scale * diameter for diameter in PRESET_DIAMETERS[count])
    rings = ring_count(count)
    if rings is None:
        raise PalpateError(
            f"{count} markers do not fill rings of 6, 12, 18, … about the apex.",
            "Take 1 + 3 n (n + 1): 7, 19, 37, 61, 91, 127, 169, …",
            code="marker-count-not-rings",
        )
    outermost = OUTERMOST * 2.0 * base_radius
    return tuple(outermost * k / rings for k in range(1, rings + 1))
