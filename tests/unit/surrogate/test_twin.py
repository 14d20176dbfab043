"""The twin of a design against presses that it has not seen, whole presses of other units, and closed forms."""

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from errors import refused
from palpate.camera import build_camera
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import BallSpec, Press, WallSpec
from palpate.fea.press import IncrementFields
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import TWIN_DERIVATIVES, TWIN_STATE, Twin, measure_interpolation_error, read_twin, write_twin
from palpate.surrogate.press_field import find_nodes
from palpate.surrogate.tensor_spline import fit_spline
from presses import build_twin, solve_press
from small_chain import EDGE_SHARE, TWIN_CELLS, TWIN_TILTS, twin_presses

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")
SKIN = DomeSpec(height=20, thickness=2)
DOME = build_skin(SKIN)
LAYOUT = place_markers(DOME, MarkerSpec(count=37))
CAMERA = build_camera()
SOLVER = SolverSpec(edge_share=EDGE_SHARE)


def press(
    tilt: float, contact: str | float, thickness: float = 2.0, derivatives: tuple[str, ...] = (), **wall: float
) -> Press:
    skin = build_skin(SKIN.model_copy(update={"thickness": thickness}))
    spec = WallSpec(tilt_deg=tilt, contact=contact, depth=4.0, depth_step=0.5, **wall)
    solver = SOLVER.model_copy(update={"derivatives": derivatives})
    return solve_press(mesh_skin(skin, MeshSpec(cells=TWIN_CELLS)), ECOFLEX, spec, solver)


@pytest.fixture(scope="module")
def presses() -> list[Press]:
    return twin_presses()


@pytest.fixture(scope="module")
def twin(presses: list[Press]) -> Twin:
    return build_twin(presses)


def at(tilt: float, azimuth_deg: float, depth: float) -> np.ndarray:
    azimuth = np.radians(azimuth_deg)
    return np.array([tilt * np.cos(azimuth), tilt * np.sin(azimuth), depth])


def pixels_apart(found: np.ndarray, press: Press, image: int) -> float:
    """Root mean square distance of a coordinate in the image, px."""
    return float(
        np.sqrt(np.mean((CAMERA.project(found) - CAMERA.project(press.positions(LAYOUT.positions)[image])) ** 2))
    )


def test_a_press_in_another_direction_and_friction_is_foreseen(twin: Twin) -> None:
    """Tilt, direction and friction between those that were pressed; four tilts and frictions instead of seven."""
    seen = press(6.0, 0.9, azimuth_deg=77.0)
    dots = twin.with_markers(LAYOUT.positions)
    for image in (4, 8):
        motion = dots.evaluate(at(6.0, 77.0, float(seen.depth[image])), 1 / 0.9)
        assert pixels_apart(motion.positions, seen, image) < 0.03
        assert motion.force == pytest.approx(seen.force[image], abs=0.02 * seen.force[image, 2])


def test_a_friction_between_is_foreseen_by_the_derivative_by_friction(presses: list[Press]) -> None:
    seen = press(4.0, 0.6)

    def apart(given: list[Press]) -> float:
        return measure_interpolation_error(build_twin(given), [seen])

    plain = [
        replace(each, derivatives={k: v for k, v in each.derivatives.items() if k != "friction"}) for each in presses
    ]
    assert apart(presses) < 0.8 * apart(plain)
    few, blind = ([each for each in some if each.obstacle.friction not in (0.8, 1.4)] for some in (presses, plain))
    assert apart(few) < 0.8 * apart(plain)  # two frictions and a slope against four
    with refused("twin-few-tilts"):
        build_twin(blind)


def test_the_slope_by_friction_of_a_press_is_that_of_the_twin(presses: list[Press], twin: Twin) -> None:
    """Of markers and force, under a straight and a tilted wall; a row with one press without it has none."""
    dots = twin.with_markers(LAYOUT.positions)
    for tilt in (0.0, 8.0):
        one = next(each for each in presses if (each.obstacle.radial, each.obstacle.contact) == (tilt, 0.8))
        slope = one.derivatives["friction"]
        motion = dots.evaluate(at(tilt, 0.0, float(one.depth[8])), 1 / 0.8)
        force = motion.force_jacobian["inverse_friction"]
        assert force[2] == pytest.approx(-(0.8**2) * slope.force[8, 2], rel=0.02)
        assert abs(force[2]) > 1e-3
    bare = [replace(each, derivatives={**each.derivatives}) for each in presses]
    del bare[9].derivatives["friction"]
    plain = build_twin(bare).amplitudes.coefficients
    without = [replace(each, derivatives={**each.derivatives}) for each in presses]
    for each in without[8:12]:
        del each.derivatives["friction"]
    assert np.isfinite(plain).all()
    assert plain == pytest.approx(build_twin(without).amplitudes.coefficients, abs=2e-3)


def test_without_depth_nothing_moves(twin: Twin) -> None:
    motion = twin.with_markers(LAYOUT.positions).evaluate(at(5.0, 30.0, 0.0), 0.5)
    assert motion.positions == pytest.approx(LAYOUT.positions, abs=2e-3)
    assert np.abs(motion.force).max() < 1e-3


@pytest.mark.parametrize("azimuth_deg", [0.0, 111.0, 260.0])
def test_a_turned_wall_turns_everything(twin: Twin, azimuth_deg: float) -> None:
    """The dots of a print that is turned along move as those of the other, turned; so does the force."""
    angle = np.radians(azimuth_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    here = twin.with_markers(LAYOUT.positions).evaluate(at(7.0, 20.0, 2.0), 0.8)
    there = twin.with_markers(LAYOUT.positions @ turn.T).evaluate(at(7.0, 20.0 + azimuth_deg, 2.0), 0.8)
    assert there.positions == pytest.approx(here.positions @ turn.T, abs=1e-9)
    assert there.force == pytest.approx(turn @ here.force, abs=1e-12)


def test_derivatives_are_those_of_the_values(twin: Twin) -> None:
    dots, pose, step = twin.with_markers(LAYOUT.positions), at(6.5, 200.0, 2.3), 1e-5
    drift = np.array([0.2, -0.3, 0.8])
    motion = dots.evaluate(pose, 0.7, 0.02, drift, 3.0)
    for k, name in enumerate(TWIN_STATE):
        changes = np.eye(9)[k] * step
        high, low = (
            dots.evaluate(
                pose + side * changes[:3],
                0.7 + side * changes[3],
                0.02 + side * changes[4],
                drift + side * changes[6:],
                3.0 + side * changes[5],
            )
            for side in (1, -1)
        )
        assert motion.jacobian[name] == pytest.approx((high.positions - low.positions) / (2 * step), abs=1e-6)
        assert motion.force_jacobian[name] == pytest.approx((high.force - low.force) / (2 * step), abs=1e-7)


def test_a_wall_that_is_not_flat_is_foreseen(twin: Twin) -> None:
    """Against whole presses under a ball of radius 250 mm, and under a bowl of the same."""
    dots, pose = twin.with_markers(LAYOUT.positions), at(6.0, 0.0, 3.2)
    for bend in (4.0, -4.0):
        wall = WallSpec(tilt_deg=6.0, contact=0.9, depth=3.2, depth_step=1.6, curvature=bend)
        seen = solve_press(mesh_skin(build_skin(SKIN), MeshSpec(cells=TWIN_CELLS)), ECOFLEX, wall, SOLVER)
        told, blind = (dots.evaluate(pose, 1 / 0.9, curvature=each) for each in (bend, 0.0))
        assert pixels_apart(told.positions, seen, -1) < 0.03
        assert pixels_apart(blind.positions, seen, -1) > 0.1


def test_at_the_straight_press_the_directions_are_alike(twin: Twin) -> None:
    """Nothing tells a direction from another at tilt 0: both derivatives are one pattern, a quarter turn apart.

    Exactly for the force; the displacement has what the coarse mesh adds in odd orders beyond the first.
    """
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    places = LAYOUT.positions
    first, second = (
        twin.with_markers(dots).evaluate(at(0.0, 0.0, 2.0), 0.5) for dots in (places, places @ quarter.T)
    )
    assert second.force_jacobian["ry_deg"] == pytest.approx(quarter @ first.force_jacobian["rx_deg"], abs=1e-6)
    here, there = first.jacobian["rx_deg"], second.jacobian["ry_deg"]
    assert np.linalg.norm(there - here @ quarter.T) < 0.25 * np.linalg.norm(here)


def test_a_wall_that_drifts_and_twists_is_foreseen(twin: Twin) -> None:
    """A whole model under a wall that does so all the way down, in another direction, tilt and friction."""
    skin, azimuth = build_skin(SKIN), np.radians(77.0)
    wall = WallSpec(tilt_deg=6.0, azimuth_deg=77.0, contact=0.9, depth=4.0, depth_step=2.0)
    mesh, drifting = (
        mesh_skin(skin, MeshSpec(cells=TWIN_CELLS, whole=True)),
        {"lateral_rate": 0.045, "lateral_rate_across": -0.07},
    )
    seen = solve_press(mesh, ECOFLEX, wall.model_copy(update={**drifting, "twist_rate_deg": 0.3}), SOLVER)
    dots, pose = twin.with_markers(LAYOUT.positions), at(6.0, 77.0, 4.0)
    up, aside = 4.0 * wall.model_copy(update=drifting).lateral_rate, -4.0 * 0.07
    drift = np.array(
        [
            aside * np.cos(azimuth) - up * np.sin(azimuth),
            aside * np.sin(azimuth) + up * np.cos(azimuth),
            4.0 * 0.3,
        ]
    )
    told, blind = (dots.evaluate(pose, 1 / 0.9, 0.0, each) for each in (drift, np.zeros(3)))
    assert pixels_apart(told.positions, seen, -1) < 0.05
    assert pixels_apart(blind.positions, seen, -1) > 0.5
    assert told.force == pytest.approx(seen.force[-1], abs=0.03 * seen.force[-1, 2])


def test_a_twin_survives_its_file(twin: Twin, tmp_path) -> None:
    write_twin(tmp_path / "dome.h5", twin)
    again = read_twin(tmp_path / "dome.h5")
    pose = at(3.0, 50.0, 1.7)
    assert again.with_markers(LAYOUT.positions).evaluate(pose, 0.4).positions == pytest.approx(
        twin.with_markers(LAYOUT.positions).evaluate(pose, 0.4).positions, abs=1e-12
    )
    with h5py.File(tmp_path / "dome.h5", "r+") as file:
        drifts = file["lateral"][:]
        del file["lateral"]
        file["lateral"] = drifts[..., :-4]
    with refused("twin-count-wrong", "lateral", drifts.shape[-1] - 4, drifts.shape[-1]):
        read_twin(tmp_path / "dome.h5")
    (tmp_path / "none.h5").write_bytes(b"no twin")
    with refused("twin-unreadable"):
        read_twin(tmp_path / "none.h5")


def test_presses_that_make_no_twin_are_refused(presses: list[Press]) -> None:
    with refused("presses-none"):
        build_twin([])
    slippery = {"contact": "frictionless"}
    smooth = [replace(each, obstacle=each.obstacle.model_copy(update=slippery)) for each in presses[:4]]
    with refused("twin-frictionless-mixed", len(presses) + 4):
        build_twin([*presses, *smooth])
    with refused("presses-missing", "1", "8", "0.8"):
        build_twin([each for each in presses if (each.obstacle.tilt_deg, each.obstacle.contact) != (8.0, 0.8)])
    with refused("derivative-missing", "thickness"):
        build_twin([replace(presses[0], derivatives={}), *presses[1:]])
    with refused("twin-few-tilts", "2", "0", "4"):
        build_twin([each for each in presses if each.obstacle.tilt_deg <= 4.0])
    with refused("presses-designs-differ"):
        build_twin([*presses, press(0.0, 0.9, thickness=3.0, derivatives=TWIN_DERIVATIVES)])


def test_a_press_that_ends_at_once_is_named(presses: list[Press]) -> None:
    one = presses[1]
    gone = np.where(np.arange(len(one.depth)) > 0, "inverted", one.branch)
    with refused("twin-short-press", f"{one.obstacle.tilt_deg:g}", "1"):
        build_twin([presses[0], replace(one, branch=gone), *presses[2:]])


def test_a_twin_says_how_far_it_is_off_between_its_presses(presses: list[Press], twin: Twin, tmp_path: Path) -> None:
    """Against the distance of dots, found here by themselves; a dome that is thicker is told apart."""
    check = press(6.0, 0.9, azimuth_deg=77.0)
    found = measure_interpolation_error(twin, [check])
    dots = twin.with_markers(LAYOUT.positions)
    apart = [
        dots.evaluate(at(6.0, 77.0, depth), 1 / 0.9).positions - check.positions(LAYOUT.positions)[image]
        for image, depth in enumerate(check.depth)
        if depth > 0
    ]
    assert found == pytest.approx(np.sqrt(np.mean(np.sum(np.square(apart), axis=-1))), rel=0.4)
    assert found < 0.01 < measure_interpolation_error(twin, [press(6.0, 0.9, thickness=2.3)])
    assert np.isnan(twin.interpolation_error_mm)
    assert np.isnan(measure_interpolation_error(twin, []))
    write_twin(tmp_path / "twin.h5", replace(twin, interpolation_error_mm=found))
    assert read_twin(tmp_path / "twin.h5").interpolation_error_mm == found


def test_presses_that_end_early_under_one_friction_leave_the_others_as_they_were(presses: list[Press]) -> None:
    """All presses under 1.4 go over into the other state at 2 mm: the twin goes on as between no slip and 0.8."""
    cut = []
    for one in presses[4:8]:
        gone = one.depth > 2.1
        branch = np.where(gone, "inverted", one.branch)
        wild = np.where(gone[:, None, None], 7.0, one.displacement)
        cut.append(replace(one, branch=branch, displacement=wild))
    twin = build_twin([*presses[:4], *cut, *presses[8:]])
    seen = press(6.0, 0.9)
    moved = twin.with_markers(LAYOUT.positions).evaluate(at(6.0, 0.0, 4.0), 1 / 0.9)
    assert pixels_apart(moved.positions, seen, 8) < 0.06
    assert moved.force == pytest.approx(seen.force[8], abs=0.02 * seen.force[8, 2])
    assert twin.max_depth(6.0, 1 / 1.4) == pytest.approx(2.0)


def test_presses_that_jump_make_no_twin(presses: list[Press]) -> None:
    """A jump is drawn as a press has it: derivatives are nan from there on."""
    jumped = presses[5]
    field = jumped.derivatives["thickness"].displacement.copy()
    field[4:] = np.nan
    rates = {**jumped.derivatives, "thickness": replace(jumped.derivatives["thickness"], displacement=field)}
    with refused("twin-across-jump", "1", "16"):
        build_twin([*presses[:5], replace(jumped, derivatives=rates), *presses[6:]])


def from_depth(press: Press, first: float) -> Press:
    """Press without the increments before a depth, all of them on the inverted branch."""
    kept = press.depth > first - 1e-6
    parts = {name: getattr(press, name)[kept] for name in IncrementFields.__annotations__}
    rates = {
        name: replace(rate, displacement=rate.displacement[kept], force=rate.force[kept])
        for name, rate in press.derivatives.items()
    }
    return replace(press, **parts | {"branch": np.full(kept.sum(), "inverted")}, derivatives=rates)


@pytest.mark.parametrize(("first", "tilts", "counts"), [(2.5, 3, (3, 4)), (3.0, 3, None), (2.5, 2, None)])
def test_an_inverted_branch_needs_four_depths_and_three_tilts(
    presses: list[Press], first: float, tilts: int, counts: tuple[int, int] | None
) -> None:
    """Depths step by 0.5 mm to 4 mm: four from 2.5 mm on, three from 3 mm on."""
    flat = presses[:4]
    inverted = build_twin(flat, [from_depth(one, first) for one in flat[:tilts]]).inverted
    assert (None if inverted is None else (len(inverted.tilts_deg), len(inverted.depths_mm))) == counts


def test_dots_outside_the_dome_are_refused(twin: Twin) -> None:
    places = LAYOUT.positions.copy()
    places[3] = np.nan
    with refused("markers-outside-skin", "1"):
        twin.with_markers(places)


def test_a_thicker_wall_is_foreseen() -> None:
    """A whole press of a unit that is 0.1 mm thicker, of which nothing was in the twin; of one contact law only."""
    presses = [press(tilt, "frictionless", derivatives=TWIN_DERIVATIVES) for tilt in TWIN_TILTS]
    dots, image = build_twin(presses).with_markers(LAYOUT.positions), 8
    thick = press(4.0, "frictionless", thickness=2.1)
    pose = at(4.0, 0.0, float(thick.depth[image]))
    told, blind = dots.evaluate(pose, 1.0, 0.1), dots.evaluate(pose, 1.0)
    assert np.abs(told.jacobian["inverse_friction"]).max() < 1e-12  # there is no friction to depend on
    seen = [CAMERA.project(each.positions(LAYOUT.positions)[image]) for each in (thick, presses[1])]
    expected, found = seen[0] - seen[1], CAMERA.project(told.positions) - CAMERA.project(blind.positions)
    assert np.linalg.norm(found - expected) < 0.1 * np.linalg.norm(expected)
    assert told.force[2] == pytest.approx(thick.force[image, 2], rel=0.01)
    assert blind.force[2] < 0.95 * thick.force[image, 2]


@pytest.mark.parametrize("places", [(0.0, 0.3, 1.0, 1.4, 2.0), (0.0, 2.0), (0.0, 0.7, 2.0)])
def test_splines_give_cubics_exactly(places: tuple[float, ...]) -> None:
    """Along the first axis: a cubic by values, or values and slopes; a parabola without one slope."""
    rng = np.random.default_rng(0)
    axes = (np.array(places), np.linspace(-2, 3, 6), np.array([0.0, 1.0, 1.5, 4.0]))
    powers = rng.normal(size=(4, 4, 4, 2))
    powers[3] *= len(places) != 3

    def value(at: np.ndarray, orders: tuple[int, int, int] = (0, 0, 0)) -> np.ndarray:
        waves = [np.polynomial.polynomial.polyder(np.eye(4), order, axis=1) for order in orders]
        x = [np.polynomial.polynomial.polyval(place, wave.T) for place, wave in zip(at, waves, strict=True)]
        return np.einsum("i,j,k,ijkm->m", *x, powers)

    grid, slopes = (
        np.array([[[value(np.array([a, b, c]), orders) for c in axes[2]] for b in axes[1]] for a in axes[0]])
        for orders in ((0, 0, 0), (1, 0, 0))
    )
    slopes[0] = slopes[0] if len(places) == 2 else np.nan
    spline = fit_spline(axes, grid, None if len(places) > 3 else slopes)
    for place in rng.uniform([0, -2, 0], [2, 3, 4], (20, 3)):
        found = spline.evaluate(place)
        assert found[0] == pytest.approx(value(place), rel=1e-9, abs=1e-9)
        for axis in range(3):
            orders = tuple(int(axis == k) for k in range(3))
            assert found[1 + axis] == pytest.approx(value(place, orders), rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_spline_is_held_before_its_first_place_and_a_quarter_step_beyond_its_last(axis: int) -> None:
    axes = (np.array([0.0, 1.0, 3.0]), np.array([0.0, 1.0, 1.5, 4.0]), np.array([-2.0, -1.0, 1.0, 2.0]))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    spline = fit_spline(axes, grid @ np.diag([1.0, 2.0, 3.0]))
    middle = np.array([1.2, 1.1, 0.4])
    knots = np.unique(spline.knots[axis])
    most = knots[-1] + 0.25 * (knots[-1] - knots[-2])
    for asked, given in ((axes[axis][0] - 1.0, axes[axis][0]), (most - 0.01, most - 0.01), (most + 1.0, most)):
        at = np.where(np.arange(3) == axis, asked, middle)
        assert spline.evaluate(at)[0, axis] == pytest.approx(given * (axis + 1))


def test_presses_with_other_steps_or_obstacles_or_too_few_images_make_no_twin(presses: list[Press]) -> None:
    step = replace(presses[3], obstacle=presses[3].obstacle.model_copy(update={"depth_step": 0.25}))
    with refused("presses-steps-differ", "0.25", "0.5"):
        build_twin([*presses[:3], step, *presses[4:]])
    with refused("twin-few-images"):
        build_twin([replace(each.cut(0, 3), ended_depth=1.0) for each in presses])
    with refused("twin-needs-flat-wall"):
        build_twin([replace(each, obstacle=BallSpec(depth=4.0, depth_step=0.5)) for each in presses])


@pytest.mark.parametrize("name", ["modes", "amplitudes", "lateral"])
def test_a_file_with_a_number_that_is_not_finite_is_no_twin(twin: Twin, tmp_path: Path, name: str) -> None:
    write_twin(tmp_path / "dome.h5", twin)
    with h5py.File(tmp_path / "dome.h5", "r+") as file:
        values = file[name][:]
        values.flat[5] = np.inf
        file[name][...] = values
    with refused("twin-not-finite", "dome.h5"):
        read_twin(tmp_path / "dome.h5")


def test_a_file_of_another_kind_or_version_is_no_twin(twin: Twin, tmp_path: Path) -> None:
    for name, value, code in (("kind", "palpate press", "twin-unreadable"), ("version", "1", "twin-version")):
        write_twin(tmp_path / "dome.h5", twin)
        with h5py.File(tmp_path / "dome.h5", "r+") as file:
            file.attrs[name] = value
        with refused(code, "dome.h5"):
            read_twin(tmp_path / "dome.h5")


def test_mirror_images_of_nodes_are_nodes() -> None:
    nodes = np.random.default_rng(1).normal(size=(20, 3))
    order = np.random.default_rng(2).permutation(20)
    assert find_nodes(nodes, nodes[order] + 1e-9).tolist() == order.tolist()
    with refused("mesh-not-symmetric"):
        find_nodes(nodes, nodes + 0.01)
