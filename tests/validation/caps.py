"""A clamped shallow cap that snaps: under a ring load and an apex load past the limit point, and under pressure.

Curves of loads and buckling pressures are of Teng & Rotter (*Computers & Structures* 31, 211 and 32, 453, 1989), Wood
& Zienkiewicz (*Computers & Structures* 7, 725, 1977), Budiansky, Dumir & Nath and Huang, as digitised in AQUINAS-FE
(© 2023 A. Filippidis, A. J. Sadowski, Imperial College London; BSD-3-Clause, see `reference/clamped_cap_LICENSE`).
Lengths are in units of the reference: inches and mm. A quarter of the cap is one layer of cells, its edge held; the
law is neo-Hooke's, with strains below a hundredth.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from palpate.core import FloatArray
from palpate.material import Material, NeoHooke
from palpate.mechanics import Problem, Solid, make_linear_solver
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import make_solid
from palpate.verify.mapped import Grid, Turn, even, join, revolve
from palpate.verify.read_reference import Reference, read_reference
from validation import REFERENCE
from validation.arc_length import ArcLength
from validation.curves import away_from, highest, turns

_CELLS, _AROUND = 28, 1
_TOLERANCE = 1e-6
"""Greatest residual over the load."""
_BAND = 0.03
"""Tolerance of curves and pressures, of the range of two codes' loads where there are two."""
_RING, _NARROW = 0.42, 1.1
"""Radius of the loaded ring over the base's; of the one that stands for a load at the apex, over the thickness."""
_BETWEEN = 0.03
"""Deflection between peak and valley, in."""
_FIRST, _LONGEST, _EXACT = 0.02, 0.06, 2e-4
"""First and longest increment of a path, and the last before a symmetry is lost, over the thickness."""
_RADIUS = 100.0
_CODES = ("Teng & Rotter", "Wood & Zienkiewicz")


@dataclass(frozen=True)
class Cap:
    """A clamped cap: mean radius, thickness, base radius (one unit of length), E (force over its square), nu.

    `rings` are radii that a line of nodes follows, `around` cells in an eighth of a turn.
    """

    radius: float
    thickness: float
    base: float
    young: float
    poisson: float
    rings: tuple[float, ...] = ()
    cells: int = _CELLS
    around: int = _AROUND

    @cached_property
    def grid(self) -> Grid:
        """A quarter of the cap in one layer; the line of a ring lies between cells."""
        edge = np.arcsin(self.base / self.radius)

        def section(q: FloatArray) -> FloatArray:
            polar, r = edge * q[:, 0], self.radius + self.thickness * (q[:, 1] - 0.5)
            return np.column_stack([r * np.sin(polar), r * np.cos(polar)])

        ends = [0.0, *(float(np.arcsin(ring / self.radius) / edge) for ring in self.rings), 1.0]
        cuts = [np.zeros(1)]
        for low, high in pairwise(ends):
            cuts.append(low + (high - low) * even(max(round(self.cells * (high - low)), 1))[1:])
        return join(revolve(section, (np.concatenate(cuts), even(1)), Turn(self.around), solid=True))

    @cached_property
    def solid(self) -> Solid:
        """The quarter, held at its edge and by symmetry."""
        nodes = self.grid.nodes
        held = np.hypot(nodes[:, 0], nodes[:, 1]) > (1 - 1e-9) * self._at_edge(nodes)
        fixed = np.stack([self.grid.near(0, 0.0) | held, self.grid.near(1, 0.0) | held, held], axis=-1)
        bulk_ratio = 2 * (1 + self.poisson) / (3 * (1 - 2 * self.poisson))
        shear = self.young / (2 * (1 + self.poisson))
        return make_solid(self.grid, Material("cap", NeoHooke(shear / 2), bulk_ratio=bulk_ratio), fixed)

    def ring_load(self, radius: float) -> FloatArray:
        """Forces (n, 3) of a quarter of a unit load, downward and even on a ring of the middle surface."""
        nodes = self.grid.nodes
        middle = np.abs(np.linalg.norm(nodes, axis=1) - self.radius) < 1e-6 * self.thickness
        on = np.flatnonzero(middle & (np.abs(np.hypot(nodes[:, 0], nodes[:, 1]) - radius) < 1e-6 * self.base))
        on = on[np.argsort(np.arctan2(nodes[on, 1], nodes[on, 0]))]
        share = np.ones(len(on))  # Simpson's, consistent with quadratic edges
        share[1:-1:2], share[2:-1:2] = 4.0, 2.0
        force = np.zeros_like(nodes)
        force[on, 2] = -0.25 * share / share.sum()
        return force

    def pressure_load(self) -> FloatArray:
        """Forces (n, 3) of a unit pressure on the middle surface, along its normal at rest, spread over the wall."""
        nodes, cells = self.grid.nodes, self.solid.cells
        places = np.einsum("ga,eai->egi", self.solid.shape, nodes[cells.nodes])
        inward = -places / np.linalg.norm(places, axis=-1, keepdims=True) / self.thickness
        force = np.zeros_like(nodes)
        np.add.at(force, cells.nodes, np.einsum("eg,ga,egi->eai", cells.weight, self.solid.shape, inward))
        return force

    @property
    def apex(self) -> int:
        """The node of the middle surface on the axis."""
        return int(np.argmin(np.linalg.norm(self.grid.nodes - [0.0, 0.0, self.radius], axis=1)))

    def path(self, force: FloatArray, step: float, longest: float) -> ArcLength:
        """The path under growing forces (n, 3), in increments of a step over the thickness at first."""
        problem = Problem(self.solid, make_linear_solver(), _TOLERANCE * float(np.abs(force).max()), self.thickness)
        return ArcLength(problem, force, step * self.thickness, longest * self.thickness)

    def _at_edge(self, nodes: FloatArray) -> FloatArray:
        """Distance (n,) from the axis of the edge at each node's radius."""
        return np.linalg.norm(nodes, axis=1) * (self.base / self.radius)


def loaded_cap(name: str, thicker: float = 1.0) -> list[Row]:
    """A cap under a load on a ring at 0.42 of its base radius (``ring``), or at its apex: load over deflection.

    Parameters
    ----------
    name
        ``ring`` or ``apex``.
    thicker
        Factor on the thickness of ours; 1 but for a control that must not pass.
    """
    radius = {"ring": _RING * _LOADED.base, "apex": _NARROW * _LOADED.thickness}[name]
    cap = replace(_LOADED, rings=(radius,), thickness=thicker * _LOADED.thickness)
    data = read_reference(f"clamped_cap_{name}", REFERENCE)
    path = cap.path(cap.ring_load(radius), _FIRST, _LONGEST)
    while -path.points[-1].state.u[cap.apex, 2] < data["deflection_in"].max():
        path.advance()
    curve = np.array([(-point.state.u[cap.apex, 2], point.factor) for point in path.points])
    rows = []
    for code in _CODES:
        theirs = np.column_stack([data.where(code=code)[column] for column in ("deflection_in", "load_lb")])
        away = away_from(curve, theirs)
        at = [f"{deflection:.3f} in" for deflection in theirs[:, 0]]
        rows.append(
            compare(f"distance from {code}, over deflection and load at most", away, 0 * away, _BAND, at, 1.0)
        )
    if name == "ring":
        peak, valley = turns(curve)
        rows += [_between("load at the peak, lb", peak, [_of(data, code, _first_peak) for code in _CODES])]
        rows += [_between("load in the valley, lb", valley, [_of(data, code, _valley) for code in _CODES])]
    return rows


def snapping_pressure() -> list[Row]:
    """Greatest pressure of caps of rising height over the classical one of a sphere, nu = 0.3."""
    data, found = read_reference("clamped_cap_snap", REFERENCE), []
    for rise in data["rise_parameter"]:
        cap = _shallow(float(rise), 0.3)
        path = cap.path(cap.pressure_load(), _FIRST, _LONGEST)
        while len(path.points) < 3 or path.points[-1].factor > path.points[-2].factor:
            path.advance()
        found.append(highest(np.array([point.factor for point in path.points[-3:]])) / _classical(cap))
    codes = np.array([data[name] for name in ("Budiansky", "DumirNath", "TengRotter")])
    nearest = np.clip(found, codes.min(axis=0), codes.max(axis=0))
    at = [f"lambda = {rise:g}" for rise in data["rise_parameter"]]
    return [compare("pressure over p0, to the nearest of three codes", found, nearest, _BAND, at)]


def buckling_pressure() -> list[Row]:
    """Pressure at which caps leave their symmetry, and their waves around, nu = 1/3; even numbers of waves."""
    data, found, waves = read_reference("clamped_cap_buckling", REFERENCE), [], []
    for rise in data["rise_parameter"]:
        cap = _shallow(float(rise), 1 / 3, around=3)
        path = cap.path(cap.pressure_load(), _FIRST, _LONGEST)
        while path.points[-1].negative_pivots == 0 or path.step > _EXACT * cap.thickness:
            if path.points[-1].negative_pivots > 0:
                path.go_back(path.step / 4)
            path.longest = path.step
            path.advance()
        found.append(path.points[-1].factor / _classical(cap))
        waves.append(_waves(cap, path.softest_mode()))
    codes = np.array([data["Huang"], data["TengRotter"]])
    at = [f"lambda = {rise:g}" for rise in data["rise_parameter"]]
    return [
        compare("pressure over p0", found, np.clip(found, codes.min(axis=0), codes.max(axis=0)), _BAND, at),
        compare("waves around", waves, data["waves"], 1e-9, at),
    ]


def _shallow(rise: float, poisson: float, around: int = _AROUND) -> Cap:
    """A cap of R = 100, t = 1 mm whose rise is ``t lambda² / (4 sqrt(3 (1 - nu²)))``."""
    height = rise**2 / (4 * np.sqrt(3 * (1 - poisson**2)))
    base = float(np.sqrt(2 * _RADIUS * height - height**2))
    return Cap(_RADIUS, 1.0, base, 2e5, poisson, around=around)


def _classical(cap: Cap) -> float:
    """Classical buckling pressure of a sphere, ``2 E t² / (R² sqrt(3 (1 - nu²)))``."""
    slender = cap.thickness / cap.radius
    return float(2 * cap.young * slender**2 / np.sqrt(3 * (1 - cap.poisson**2)))


def _of(data: Reference, code: str, pick: Callable[[FloatArray, FloatArray], float]) -> float:
    part = data.where(code=code)
    return pick(part["deflection_in"], part["load_lb"])


def _first_peak(deflection: FloatArray, load: FloatArray) -> float:
    return float(load[deflection < _BETWEEN].max())


def _valley(deflection: FloatArray, load: FloatArray) -> float:
    return float(load[deflection > _BETWEEN].min())


def _between(quantity: str, ours: float, theirs: list[float]) -> Row:
    """A figure against the nearest within the range of the codes."""
    return compare(quantity, ours, float(np.clip(ours, min(theirs), max(theirs))), _BAND)


def _waves(cap: Cap, mode: FloatArray) -> int:
    """Number of waves around of a mode (n, 3): the even order of its vertical part that is strongest."""
    azimuth = np.arctan2(cap.grid.nodes[:, 1], cap.grid.nodes[:, 0])
    orders = np.arange(0, 14, 2)
    strength = [abs(float(mode[:, 2] @ np.cos(order * azimuth))) for order in orders]
    return int(orders[int(np.argmax(strength))])


_LOADED = Cap(4.758, 0.01576, 0.9, 1e7, 0.3)
"""Inches and pounds per square inch."""
