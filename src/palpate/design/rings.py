"""Rings of markers: one at the apex, then 6, 12, 18, … in rings about it.

n rings contain 1 + 6 + 12 + … + 6 n = 1 + 3 n (n + 1) markers: 7, 19, 37, 61, 91, 127, 169, …
"""

from __future__ import annotations

from palpate.core import PalpateError

MAX_RINGS = 20
"""Maximum number of rings, beyond the resolution of current cameras."""

OUTERMOST = 0.875
"""Diameter of the outermost ring over the base diameter, without a preset (169 markers: 35/40)."""

PRESET_BASE_RADIUS = 20.0
"""Base radius of `PRESET_DIAMETERS`, mm."""

PRESET_DIAMETERS: dict[int, tuple[float, ...]] = {
    7: (18.0,),
    37: (10.0, 20.0, 30.0),
    91: (6.0, 12.0, 18.0, 24.0, 30.0),
    169: (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0),
}
"""Ring diameters projected on the base plane, mm, by number of markers, of `palpate.core.PAPER`."""


def markers_in_rings(rings: int) -> int:
    """Return the number of markers of `rings` rings and the apex: 1 + 3 n (n + 1)."""
    return 1 + 3 * rings * (rings + 1)


def ring_count(count: int) -> int | None:
    """Return the number of rings that contain `count` markers, or `None` if they do not fill rings."""
    for rings in range(MAX_RINGS + 1):
        if markers_in_rings(rings) == count:
            return rings
    return None


def ring_diameters(count: int, base_radius: float = PRESET_BASE_RADIUS) -> tuple[float, ...]:
    """Return the ring diameters (mm, on the base plane) of `count` markers, from the apex outward.

    A preset is scaled with the base radius (of the inner surface, mm); other rings are spaced evenly up to 0.875 of
    the base diameter.

    Raises
    ------
    PalpateError
        If `count` is not a ring number 1 + 3 n (n + 1).

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
            "Use 1 + 3 n (n + 1): 7, 19, 37, 61, 91, 127, 169, …",
            code="marker-count-not-rings",
        )
    outermost = OUTERMOST * 2.0 * base_radius
    return tuple(outermost * k / rings for k in range(1, rings + 1))
