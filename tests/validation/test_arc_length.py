"""Paths by arc length, against load control before the limit point, and against the energy beyond it."""

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from errors import refused
from palpate.verify.equilibrium import follow_load
from validation.arc_length import ArcLength
from validation.caps import Cap

RING = 0.38
CAP = Cap(4.758, 0.01576, 0.9, 1e7, 0.3, (RING,), cells=18)


@pytest.fixture(scope="module")
def path() -> ArcLength:
    found = CAP.path(CAP.ring_load(RING), 0.02, 0.1)
    while deflection(found)[-1] < 0.1:
        found.advance()
    return found


def deflection(path: ArcLength) -> np.ndarray:
    return np.array([-point.state.u[CAP.apex, 2] for point in path.points])


def test_the_load_rises_falls_and_rises_again(path: ArcLength) -> None:
    load = np.array([point.factor for point in path.points])
    turns = np.flatnonzero(np.diff(np.sign(np.diff(load)))) + 1
    assert load[turns] == pytest.approx([75.0, 38.0], rel=0.04)
    assert (np.diff(deflection(path)) > 0).all()


def test_one_mode_is_unstable_while_the_load_falls(path: ArcLength) -> None:
    load = np.array([point.factor for point in path.points])
    pivots = np.array([point.negative_pivots for point in path.points])
    peak, valley = int(np.argmax(load)), int(np.argmax(load)) + int(np.argmin(load[np.argmax(load) :]))
    assert (pivots[: peak - 1] == 0).all()
    assert (pivots[peak + 2 : valley - 1] == 1).all()
    assert (pivots[valley + 2 :] == 0).all()


def test_the_energy_stored_is_the_work_of_the_load_beyond_both_limit_points(path: ArcLength) -> None:
    way = np.array([float((path.force * point.state.u).sum()) for point in path.points])
    load = np.array([point.factor for point in path.points])
    # both as splines over the number of the point, for the load turns back along neither
    number, fine = np.arange(len(load)), np.linspace(0, len(load) - 1, 100 * (len(load) - 1) + 1)
    power = CubicSpline(number, load)(fine) * CubicSpline(number, way)(fine, 1)
    work = cumulative_simpson(power, x=fine, initial=0.0)[::100]
    stored = [path.problem.assemble(point.state, ()).elastic for point in path.points]
    assert np.abs(work - stored).max() < 0.001 * max(stored)


def test_before_the_limit_point_it_is_the_path_of_a_growing_load(path: ArcLength) -> None:
    point = path.points[3]
    assert 10 < point.factor < 60
    factors = np.linspace(0.2, 1.0, 5) * point.factor
    alone = follow_load(CAP.grid, CAP.solid.material, CAP.solid.fixed, path.force, factors)[-1]
    assert alone.u == pytest.approx(point.state.u, abs=1e-5 * np.abs(point.state.u).max())


def test_a_step_back_goes_on_along_the_same_path(path: ArcLength) -> None:
    """Half the way to the tenth point, and half again: load and deflection lie on the curve of the others."""
    again = ArcLength(path.problem, path.force, path.step, path.longest, path.points[:10])
    lost, before = again.points[-1], again.points[-2]
    went = lost.state.u - before.state.u
    length = np.sqrt(np.average((went**2).sum(axis=1), weights=path.problem.body.nodal_volume))
    again.go_back(0.5 * float(length))
    again.longest = again.step
    again.advance()
    again.advance()
    curve = np.array([[-point.state.u[CAP.apex, 2], point.factor] for point in path.points[7:12]])
    cubic = np.polyfit(curve[:, 0] - curve[2, 0], curve[:, 1], 4)
    for point in again.points[-2:]:
        there = np.polyval(cubic, -point.state.u[CAP.apex, 2] - curve[2, 0])
        assert point.factor == pytest.approx(there, rel=0.01)


def test_without_a_load_there_is_no_path() -> None:
    with refused("load-missing"):
        CAP.path(np.zeros_like(CAP.grid.nodes), 0.02, 0.1)
