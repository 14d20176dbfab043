"""Marker rings of minimum error on a skin, chosen by exchange, with a lower bound for every choice.

A ring is one of many candidates, given by its number of markers and its place along the meridian.
`palpate.calibration.RingInformation` computes the expected error of a set of rings in half a millisecond. Rings are
moved one at a time to the place of minimum error, until no move lowers it.

The expected square error is a convex function of the share of each ring that is printed, if fractional rings are
allowed (trace of the inverse of a sum; see Boyd and Vandenberghe, Convex Optimization, section 7.5). Its minimum over
mixtures of all printable sets of rings bounds each of them from below. It is found by the Frank-Wolfe method, whose
steps are shortest paths outward. Its duality gap is subtracted, so the bound holds at any number of steps. Terms of
calibration presses are not convex: the bound is that of a unit whose marker positions at rest are known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from palpate.calibration import AccuracySpec, RingInformation, ToleranceSpec, compute_ring_information
from palpate.camera import Camera
from palpate.core import BoolArray, FloatArray, IntArray, PalpateError
from palpate.design import MarkerLayout, MarkerSpec, Skin, markers_in_rings
from palpate.surrogate import Twin

_SWEEPS = 12
"""Maximum number of exchange rounds. By hand."""
_DIFFERENCE = 1e-4
"""Finite-difference step of a ring's share. By hand."""
_CLOSE = 2e-3
"""Relative gap of the expected square error at which the bound is accepted. By hand."""
_MARK_ROOM = 1.4
"""Space for the orientation mark beyond the outermost ring, over the marker diameter. By hand."""
_SLACK_MM = 0.01
"""Tolerance of a place that is known to 0.1 mm. By hand."""
_SPREADS = (1.0, 0.7)
"""Shares of the meridian over which the initial rings are spread. By hand."""


@dataclass(frozen=True)
class PrintLimits:
    """Limits of printing and of marker assignment.

    Attributes
    ----------
    max_markers
        Maximum number of markers.
    marker_diameter, gap
        Marker diameter, and minimum gap between two markers, mm.
    min_marker_diameter
        Diameter of the smallest markers that are tried, mm; `None`: `marker_diameter`.
    apart_px
        Minimum distance of two of the smallest markers in the rest image; larger ones keep the same gap between their
        edges.
    max_slope_deg
        Maximum slope of the skin for printing.
    on_arc
        Whether the pad carries markers along the meridian; else along the axis, where steep rings are close together.
    places
        Number of candidate places along the meridian.
    """

    max_markers: int = 169
    marker_diameter: float = 1.0
    gap: float = 0.3
    min_marker_diameter: float | None = None
    apart_px: float = 8.0
    max_slope_deg: float = 65.0
    on_arc: bool = False
    places: int = 28

    @property
    def rings(self) -> int:
        """Maximum number of rings."""
        count = 0
        while markers_in_rings(count + 1) <= self.max_markers:
            count += 1
        return count


@dataclass(frozen=True, eq=False)
class RingSelection:
    """Chosen rings.

    Attributes
    ----------
    markers
        The layout.
    rmse_deg
        Expected error of rx and ry.
    """

    markers: MarkerSpec
    rmse_deg: float


@dataclass(frozen=True, eq=False)
class RingCandidates:
    """All printable rings of a skin and their information.

    Attributes
    ----------
    information
        Group 0 is the apex; group 1 + (k - 1) J + j is ring k at place j.
    radii
        (J,) distance of the places from the axis, mm.
    allowed
        (K, J) whether ring k + 1 may be at a place by itself.
    steps
        (J, J) whether neighbouring rings may be at these two places.
    limits
        Limits of printing and assignment.
    """

    information: RingInformation
    radii: FloatArray
    allowed: BoolArray
    steps: BoolArray
    limits: PrintLimits

    def share(self, places: IntArray) -> FloatArray:
        """Indicator (g,) of the groups of the apex and of rings 1, 2, … at these places (n,)."""
        found = np.zeros(1 + self.allowed.size)
        found[0] = 1.0
        found[1 + np.arange(len(places)) * len(self.radii) + places] = 1.0
        return found

    def is_compatible(self, places: IntArray) -> bool:
        """Whether the rings at these places can be printed together."""
        fit = bool(self.allowed[np.arange(len(places)), places].all())
        return fit and bool(self.steps[places[:-1], places[1:]].all())


def measure_ring_candidates(
    twin: Twin, camera: Camera, tolerance: ToleranceSpec, spec: AccuracySpec, limits: PrintLimits
) -> RingCandidates:
    """Measure every printable ring on the skin of a twin."""
    skin, count = twin.skin, limits.rings
    radii = _radii(skin, limits)
    positions, group = [skin.inner_point(np.zeros(1), np.zeros(1))], [np.zeros(1, dtype=int)]
    for k in range(1, count + 1):
        azimuth = 2.0 * np.pi * np.arange(6 * k) / (6 * k)
        for j, radius in enumerate(radii):
            positions.append(skin.inner_point(np.full(6 * k, radius), azimuth))
            group.append(np.full(6 * k, 1 + (k - 1) * len(radii) + j))
    layout = MarkerLayout(np.concatenate(positions), limits.marker_diameter)
    information = compute_ring_information(twin, layout, np.concatenate(group), camera, tolerance, spec)
    return RingCandidates(information, radii, *_allow(skin, camera, limits, radii, information.inside), limits)


def resize_dots(places: RingCandidates, skin: Skin, camera: Camera, dot: float, noise_px: float) -> RingCandidates:
    """Return the same rings with markers of another diameter (mm), at least that of the first.

    The poses are not evaluated again: the information changes by the marker noise, which is `noise_px` for a marker
    of 4.4 px in the image, and the permitted places by the marker size.
    """
    limits = replace(
        places.limits,
        marker_diameter=dot,
        min_marker_diameter=places.limits.min_marker_diameter or places.limits.marker_diameter,
    )
    radii = np.append(0.0, np.tile(places.radii, limits.rings))
    layout = MarkerLayout(skin.inner_point(radii, np.zeros(len(radii))), dot)
    information = places.information.with_markers(skin, layout, np.arange(len(radii)), camera, noise_px)
    allowed, steps = _allow(skin, camera, limits, places.radii, places.information.inside)
    return RingCandidates(information, places.radii, allowed, steps, limits)


def _allow(
    skin: Skin, camera: Camera, limits: PrintLimits, radii: FloatArray, inside: BoolArray
) -> tuple[BoolArray, BoolArray]:
    """Permitted places of every ring by itself (K, J), and of neighbouring rings (J, J)."""
    apart = _apart(skin, camera, limits, radii)
    numbers = np.arange(1, limits.rings + 1)[:, None]
    within = 2.0 * radii * np.sin(np.pi / (6 * numbers)) >= apart
    points = skin.inner_point(radii, np.zeros(len(radii)))
    along = skin.arc_length(points)
    whole = (radii <= _printable(skin, limits).max(initial=0.0) + _SLACK_MM) & (
        skin.distance_to_rim(points) >= limits.marker_diameter - _SLACK_MM
    )
    allowed = inside[1:].reshape(len(numbers), len(radii)) & within & (along >= apart) & whole
    on_pad = along if limits.on_arc else radii
    steps = (along[None, :] - along[:, None] >= apart) & (
        on_pad[None, :] - on_pad[:, None] >= limits.marker_diameter + limits.gap
    )
    return allowed, steps


def choose_rings(places: RingCandidates, markers: int) -> RingSelection:
    """Choose the rings of one number of markers.

    Raises
    ------
    PalpateError
        If this number cannot be printed on the skin.
    """
    starts = [_spread(places, markers, share) for share in _SPREADS]
    best, least = min((_exchange(places, start) for start in starts), key=lambda found: found[1])
    return RingSelection(_markers(places, best), float(np.sqrt(least)))


def space_rings_evenly(places: RingCandidates, markers: int) -> RingSelection:
    """Return the rings of one number of markers that are spaced most evenly along the meridian.

    Raises
    ------
    PalpateError
        If this number cannot be printed on the skin.
    """
    even = _spread(places, markers, 1.0)
    return RingSelection(_markers(places, even), float(np.sqrt(places.information.variance(places.share(even)))))


def _spread(places: RingCandidates, markers: int, share: float) -> IntArray:
    """Places of evenly spaced rings over a share of the meridian."""
    count = next((n for n in range(1, places.limits.rings + 1) if markers_in_rings(n) == markers), None)
    if count is None:
        raise PalpateError(
            f"{markers} markers are no rings.", f"Take {_counts(places.limits)}.", code="marker-count-not-rings"
        )
    wanted = np.linspace(share / count, share, count) * (len(places.radii) - 1)
    return _best_chain(places, (np.arange(len(places.radii)) - wanted[:, None]) ** 2.0)


def _counts(limits: PrintLimits) -> str:
    return ", ".join(str(markers_in_rings(n)) for n in range(1, limits.rings + 1))


def _radii(skin: Skin, limits: PrintLimits) -> FloatArray:
    """Printable distances of a ring from the axis, evenly spaced along the meridian."""
    rho = _printable(skin, limits)
    reach = float(skin.arc_length(skin.inner_point(rho, np.zeros(len(rho))))[-1]) if len(rho) else 0.0
    least = limits.marker_diameter + limits.gap
    if reach <= least:
        raise PalpateError(
            f"Only {reach:.2g} mm of the meridian can be printed.",
            "Take a wider skin.",
            code="meridian-not-printable",
        )
    return skin.at_arc_length(np.linspace(least, reach, limits.places))


def _printable(skin: Skin, limits: PrintLimits) -> FloatArray:
    """Finely spaced printable distances from the axis, limited by the pad and the clamp.

    Space for the orientation mark is left beyond the outermost ring.
    """
    rho = np.linspace(0.0, skin.widest[0], 401)[1:-1]
    points = skin.inner_point(rho, np.zeros(len(rho)))
    steep = np.degrees(np.arccos(np.clip(skin.normal(points)[:, 2], -1.0, 1.0)))
    fine = (steep <= limits.max_slope_deg) & (skin.distance_to_rim(points) >= limits.marker_diameter)
    if not fine.any():
        raise PalpateError(
            "No ring can be printed on this skin.",
            "Take a flatter or wider skin, or smaller markers.",
            code="rings-not-printable",
        )
    return np.asarray(rho[fine & (rho <= rho[fine].max() - _MARK_ROOM * limits.marker_diameter)], float)


def _apart(skin: Skin, camera: Camera, limits: PrintLimits, radii: FloatArray) -> FloatArray:
    """Minimum distance (J,) mm of neighbouring markers at each place, by the pad and by the rest image."""
    points = skin.inner_point(radii, np.zeros(len(radii)))
    near = skin.inner_point(radii * 0.99, np.zeros(len(radii)))
    seen = np.linalg.norm(camera.project(points) - camera.project(near), axis=1)
    scale = seen / np.linalg.norm(points - near, axis=1)
    larger = limits.marker_diameter - (limits.min_marker_diameter or limits.marker_diameter)
    return np.maximum(limits.marker_diameter + limits.gap, limits.apart_px / np.maximum(scale, 1e-6) + larger)


def _exchange(places: RingCandidates, start: IntArray) -> tuple[IntArray, float]:
    """Move single rings and groups of rings as long as the error falls."""
    now, known = start.copy(), dict[tuple[int, ...], float]()

    def evaluate(chosen: IntArray) -> float:
        key = tuple(int(place) for place in chosen)
        if key not in known:
            known[key] = places.information.variance(places.share(chosen)) if places.is_compatible(chosen) else np.inf
        return known[key]

    least = evaluate(now)
    for _ in range(_SWEEPS):
        before = least
        for moved in _moves(len(now), len(places.radii)):
            for shift in range(len(places.radii)):
                other = now.copy()
                other[moved] = shift if len(moved) == 1 else other[moved] + shift - len(places.radii) // 2
                if (other < 0).any() or (other >= len(places.radii)).any():
                    continue
                if evaluate(other) < least * (1 - 1e-9):
                    now, least = other, evaluate(other)
        if least >= before * (1 - 1e-6):
            break
    return now, least


def _moves(rings: int, places: int) -> list[IntArray]:
    """Sets of rings that are moved together: each ring, and all rings outward or inward of one."""
    every = np.arange(rings)
    single = [every[k : k + 1] for k in range(rings)]
    runs = [every[k:] for k in range(rings - 1)] + [every[: k + 1] for k in range(1, rings - 1)]
    return single + runs


def _markers(places: RingCandidates, chosen: IntArray) -> MarkerSpec:
    diameters = tuple(round(2.0 * float(radius), 3) for radius in places.radii[chosen])
    return MarkerSpec(
        count=markers_in_rings(len(diameters)), ring_diameters=diameters, diameter=places.limits.marker_diameter
    )


def bound_rings(places: RingCandidates, markers: int, steps: int = 40) -> float:
    """Lower bound on the expected error of rx and ry, degrees, over all rings of this number of markers.

    The bound is the minimum over mixtures of all printable sets of rings.
    """
    information = places.information.lower_bound()
    count = next(n for n in range(1, places.limits.rings + 1) if markers_in_rings(n) == markers)
    share, bound = places.share(_best_chain(places, np.zeros((count, len(places.radii))))), 0.0
    for step in range(steps):
        value, slope = information.variance(share), np.zeros_like(places.allowed[:count], dtype=float)
        for k, j in np.argwhere(places.allowed[:count]):
            more = share.copy()
            more[1 + k * len(places.radii) + j] += _DIFFERENCE
            slope[k, j] = (information.variance(more) - value) / _DIFFERENCE
        vertex = places.share(_best_chain(places, slope))
        along = vertex - share
        bound = max(bound, value + float(slope.ravel() @ along[1 : 1 + slope.size]))
        if value - bound < _CLOSE * value:
            break
        tried = np.array([0.5, 1.0, 2.0, 4.0]) / (step + 2.0)
        values = [information.variance(share + size * along) for size in np.minimum(tried, 1.0)]
        share = share + min(1.0, tried[int(np.argmin(values))]) * along
    return float(np.sqrt(bound))


def _best_chain(places: RingCandidates, cost: FloatArray) -> IntArray:
    """Places of minimum total `cost` (n, J) for n rings: the shortest path outward."""
    least = np.where(places.allowed[0], cost[0], np.inf)
    came = np.zeros(cost.shape, dtype=int)
    for k in range(1, len(cost)):
        ways = np.where(places.steps, least[:, None], np.inf)
        came[k] = ways.argmin(axis=0)
        least = ways.min(axis=0) + np.where(places.allowed[k], cost[k], np.inf)
    if not np.isfinite(least.min()):
        raise PalpateError(
            f"{markers_in_rings(len(cost))} markers cannot be printed on this skin and be resolved in the image.",
            "Take fewer markers, smaller markers, or a larger skin.",
            code="markers-not-printable",
        )
    found = [int(least.argmin())]
    for k in range(len(cost) - 1, 0, -1):
        found.append(int(came[k, found[-1]]))
    return np.array(found[::-1])
