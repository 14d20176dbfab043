"""One function relaxes a whole press: held against a press whose every point relaxes by itself."""

import numpy as np
import pytest

from fading_press import press_fading
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec
from palpate.material import ForceCurve, Moduli, Relaxation, get_material, simulate_depth_hold
from palpate.mesh import MeshSpec, mesh_skin
from presses import solve_press

SERIES = Relaxation((0.15, 0.15), (0.5, 5.0), Moduli.INSTANTANEOUS)
HOLDS = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)


def compare(contact, ramp, depth):
    """Force over the relaxed elastic force less 1, and distance of markers from the elastic press (mm, rms)."""
    found = press_fading(SERIES, WallSpec(tilt_deg=5, depth=depth, depth_step=0.25, contact=contact), ramp, HOLDS)
    curve = ForceCurve(found.elastic.depth, found.elastic.force)
    course = simulate_depth_hold(SERIES, curve, np.append(0.0, found.time), np.append(0.0, found.depth))
    dots = place_markers(build_skin(DomeSpec(height=20, thickness=2)), MarkerSpec(count=91)).positions
    still = found.elastic.positions(dots)
    last = len(found.elastic.depth) - 1
    away = [moved - still[min(k + 1, last)] for k, moved in enumerate(found.markers)]
    off = found.force[:, 2] / course.force[1:, 2] - 1
    without = curve.force[-1, 2] / found.force[-1, 2] - 1
    return off, np.sqrt(np.mean(np.sum(np.square(away), axis=2), axis=1)), without


def test_after_a_quick_touch_only_the_force_changes():
    """4 mm in 10 ms without slip: the force is the elastic one relaxed at every time, and the markers stay."""
    off, away, without = compare("no-slip", 0.01, 4.0)
    held = len(HOLDS) + 1
    assert np.abs(off[3:]).max() < 3e-3  # without slip the first millimetre depends on how many increments it has
    assert np.abs(off[-held:]).max() < 5e-4
    assert away[3:].max() < 2e-3
    assert np.ptp(away[-held:]) < 1e-4  # from when the wall stops to 30 s later
    assert without > 0.4  # the control: without relaxation the force of 30 s would be 43 % off


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["frictionless", "no-slip", 0.5])
def test_a_press_that_takes_as_long_as_it_relaxes_is_near_and_comes_nearer(contact):
    """8 mm in 1 s: history turned with the material leaves 4 % and 0.012 mm when the wall stops, and that fades."""
    off, away, _ = compare(contact, 1.0, 8.0)
    stop = len(off) - len(HOLDS) - 1
    assert 0.01 < off[stop] < 0.05
    assert 0.005 < away[stop] < 0.014
    assert abs(off[-1]) < 1e-3
    assert away[-1] < (0.002 if isinstance(contact, str) else 0.007)


@pytest.mark.slow
def test_a_bulk_that_does_not_relax_hardly_moves_the_markers():
    """K/mu 4000 for 2000, as if half of the stress were lost; K/mu 20 is the control that must move them."""
    skin = build_skin(DomeSpec(height=20, thickness=2))
    mesh, dots = mesh_skin(skin, MeshSpec()), place_markers(skin, MarkerSpec(count=91)).positions
    wall = WallSpec(tilt_deg=5, depth=8, depth_step=0.8, contact="frictionless")
    silicone = get_material("zaid_2024_ecoflex_00_30")
    presses = {ratio: solve_press(mesh, silicone.with_bulk_ratio(ratio), wall) for ratio in (2000, 4000, 20)}
    places = {ratio: press.positions(dots)[-1] for ratio, press in presses.items()}
    assert np.linalg.norm(places[4000] - places[2000], axis=1).max() < 5e-4
    assert np.linalg.norm(places[20] - places[2000], axis=1).max() > 0.01
    assert presses[4000].force[-1] == pytest.approx(presses[2000].force[-1], rel=1e-3)
