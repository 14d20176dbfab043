"""Tolerances, mounting, force, noise and sums of calibration against integrals, differences and brute force."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import integrate, optimize, stats

from errors import refused
from palpate.calibration import (
    UNIT_PARAMETERS,
    Force,
    IdentifiedUnit,
    ScalarEstimate,
    ToleranceSpec,
    calibration_pose,
    predict_force,
    prior_stiffness_scale,
    read_unit,
    update_stiffness_scale,
    write_unit,
)
from palpate.calibration.camera_derivatives import CameraDerivatives, project_with_jacobian
from palpate.calibration.force import scale_force
from palpate.calibration.groups import sum_by_group
from palpate.calibration.mounting import MOUNTING_PARAMETERS, Mounting, mounting_prior_sd, prior_mounting
from palpate.calibration.noise import FREEDOM, robust_weights
from palpate.calibration.unit_model import CAMERA_PARAMETERS, LEAST_SD, UnitPosterior, unit_prior_sd
from palpate.camera import Camera, CameraSpec, WindowSpec, build_camera
from palpate.core.state import State

SHARES = np.linspace(0.0, 1.0, 20001)
UNIFORM_SD = float(np.std(2.0 * SHARES - 1.0))
"""Standard deviation of a quantity that is uniform from -1 to 1."""
TURN = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]


def averages(values: np.ndarray) -> tuple[float, float]:
    """Mean and standard deviation of a quantity over equal shares."""
    mean = integrate.simpson(values, x=SHARES)
    return float(mean), float(np.sqrt(integrate.simpson((values - mean) ** 2, x=SHARES)))


def test_friction_is_uniform_up_to_twice_its_minimum_or_its_inverse_between_both_limits() -> None:
    plain, both = ToleranceSpec(friction_min=0.6), ToleranceSpec(friction_min=0.25, friction_max=2.0)
    assert [plain.friction_at(share) for share in (0.0, 0.5, 1.0)] == pytest.approx([0.6, 0.9, 1.2])
    assert [both.friction_at(share) for share in (0.0, 1.0)] == pytest.approx([2.0, 0.25])
    inverse = np.array([1.0 / both.friction_at(share) for share in SHARES])
    assert np.ptp(np.diff(inverse)) == pytest.approx(0.0, abs=1e-9)
    wide = ToleranceSpec(friction_min=0.1, friction_max=2.0)
    spread = averages(np.array([1.0 / wide.friction_at(share) for share in SHARES]))
    assert wide.inverse_friction_prior == pytest.approx(spread, rel=1e-3)
    assert both.inverse_friction_prior[0] == pytest.approx(averages(inverse)[0], rel=1e-6)
    assert both.inverse_friction_prior[1] >= averages(inverse)[1], "never surer than of silicone on metal"
    assert plain.inverse_friction_prior == ToleranceSpec().inverse_friction_prior


@pytest.mark.parametrize("limits", [(0.5, 0.4), (0.0, 0.4)])
def test_limits_of_friction_that_do_not_rise_are_refused(limits: tuple[float, float]) -> None:
    with refused("frictions-not-rising", *(f"{limit:g}" for limit in limits)):
        ToleranceSpec(friction_min=limits[0], friction_max=limits[1])
    assert ToleranceSpec(friction_min=0.4, friction_max=0.4).friction_at(0.3) == pytest.approx(0.4)


def test_a_prior_is_uniform_within_the_tolerance_of_its_own_parameter() -> None:
    sizes = {
        "camera_offset": 0.1,
        "camera_distance": 0.2,
        "camera_tilt_deg": 0.3,
        "camera_roll_deg": 0.4,
        "focal": 0.05,
        "centre_px": 0.6,
        "distortion": 0.07,
        "thickness": 0.8,
        "seating_tilt_deg": 0.9,
        "seating_turn_deg": 1.1,
        "depth_zero": 1.2,
        "curvature": 1.3,
        "lateral": 1.4,
        "twist_deg": 1.5,
        "modulus": 0.16,
    }
    tolerance = ToleranceSpec(**sizes)
    unit = dict(zip(UNIT_PARAMETERS, unit_prior_sd(tolerance) / UNIFORM_SD, strict=True))
    wanted = {"offset_x": 0.1, "offset_y": 0.1, "distance": 0.2, "tilt_x_deg": 0.3, "tilt_y_deg": 0.3}
    wanted |= {"roll_deg": 0.4, "focal": 0.05, "centre_x_px": 0.6, "centre_y_px": 0.6, "k1": 0.07, "thickness": 0.8}
    assert unit == pytest.approx(wanted, rel=1e-3)
    assert mounting_prior_sd(tolerance) / UNIFORM_SD == pytest.approx([0.9, 0.9, 1.1, 1.2], rel=1e-3)
    assert tolerance.curvature_sd / UNIFORM_SD == pytest.approx(1.3, rel=1e-3)
    assert np.array(tolerance.lateral_sd) / UNIFORM_SD == pytest.approx([1.4, 1.4, 1.5], rel=1e-3)
    assert prior_stiffness_scale(tolerance) == pytest.approx((1.0, 0.16 * UNIFORM_SD), rel=1e-3)
    none = ToleranceSpec(camera_offset=0.0, seating_tilt_deg=0.0)
    assert (unit_prior_sd(none)[0], mounting_prior_sd(none)[0]) == (LEAST_SD, LEAST_SD)


def mounted() -> Mounting:
    return Mounting(State(MOUNTING_PARAMETERS, np.array([0.3, -0.7, 20.0, 0.4])), np.eye(15))


def test_a_pose_goes_to_the_robot_by_a_rotation_and_comes_back() -> None:
    quarter = Mounting(State(MOUNTING_PARAMETERS, np.array([0.5, 0.25, 90.0, 0.4])), np.eye(15))
    assert quarter.to_robot(np.array([1.0, 2.0, 3.0])) == pytest.approx([-1.5, 1.25, 3.4])
    pose = np.array([2.0, -1.0, 3.0])
    assert mounted().to_dome(mounted().to_robot(pose)) == pytest.approx(pose)
    assert np.linalg.norm(mounted().to_robot(pose)[:2] - [0.3, -0.7]) == pytest.approx(np.linalg.norm(pose[:2]))


def test_the_jacobian_of_a_mounting_is_that_of_differences() -> None:
    pose, steps = np.array([2.0, -1.0, 3.0]), 1e-4 * np.eye(4)
    rows = [(mounted().to_robot(pose, step) - mounted().to_robot(pose, -step)) / 2e-4 for step in steps]
    assert mounted().jacobian(pose) == pytest.approx(np.transpose(rows), abs=1e-8)


def posterior() -> UnitPosterior:
    spread = np.diag(np.arange(1.0, 12.0))
    return UnitPosterior(CameraSpec(), np.array([[10.0, 20.0], [30.0, 40.0]]), State.zeros(UNIT_PARAMETERS), spread)


def test_the_mounting_before_any_press_is_independent_of_the_unit() -> None:
    found = prior_mounting(posterior(), ToleranceSpec())
    assert found.mean.values.tolist() == [0.0] * 4
    assert found.covariance[:11, :11].tolist() == posterior().covariance.tolist()
    assert np.diag(found.covariance)[11:] == pytest.approx(mounting_prior_sd(ToleranceSpec()) ** 2)
    assert not found.covariance[:11, 11:].any()
    assert not found.covariance[11:, :11].any()


@pytest.fixture
def unit() -> IdentifiedUnit:
    belief = posterior()
    return IdentifiedUnit(
        {"kind": "dome"},
        np.array([[0.0, 0.0, 20.0], [1.0, 0.0, 19.0]]),
        belief,
        prior_mounting(belief, ToleranceSpec()),
        ScalarEstimate(1.1, 0.02),
    )


def test_a_unit_file_gives_its_numbers_back(unit: IdentifiedUnit, tmp_path: Path) -> None:
    rest = np.array([[10.0, 20.0], [np.nan, np.nan]])
    mean = State(UNIT_PARAMETERS, np.arange(11.0))
    moved = replace(unit.mounting, mean=State(MOUNTING_PARAMETERS, np.arange(20.0, 24.0)))
    unit = replace(unit, posterior=replace(unit.posterior, rest_px=rest, mean=mean), mounting=moved)
    write_unit(tmp_path / "unit.json", unit)
    again = read_unit(tmp_path / "unit.json")
    assert again.posterior.rest_px == pytest.approx(rest, nan_ok=True)
    assert again.posterior.mean.values.tolist() == mean.values.tolist()
    assert again.mounting.mean.values.tolist() == moved.mean.values.tolist()
    assert again.posterior.covariance == pytest.approx(unit.posterior.covariance)
    assert again.mounting.covariance == pytest.approx(unit.mounting.covariance)
    assert (again.scale, again.markers_mm.tolist()) == (unit.scale, unit.markers_mm.tolist())


@pytest.mark.parametrize("fault", ["covariance", "negative", "mean", "scale", "sd", "markers"])
def test_a_unit_file_with_impossible_numbers_is_refused(unit: IdentifiedUnit, tmp_path: Path, fault: str) -> None:
    covariance = unit.mounting.covariance.copy()
    covariance[3, 3] = np.nan if fault == "covariance" else -1.0
    mean = State(MOUNTING_PARAMETERS, np.array([0.0, np.inf, 0.0, 0.0]))
    changes = {
        "covariance": {"mounting": replace(unit.mounting, covariance=covariance)},
        "negative": {"mounting": replace(unit.mounting, covariance=covariance)},
        "mean": {"mounting": replace(unit.mounting, mean=mean)},
        "scale": {"scale": ScalarEstimate(0.0, 0.02)},
        "sd": {"scale": ScalarEstimate(1.0, -0.02)},
        "markers": {"markers_mm": unit.markers_mm[:1]},
    }
    with np.errstate(invalid="ignore"):
        write_unit(tmp_path / "unit.json", replace(unit, **changes[fault]))
    with refused("unit-file-damaged"):
        read_unit(tmp_path / "unit.json")
    write_unit(tmp_path / "unit.json", replace(unit, scale=ScalarEstimate(1.0, 0.0)))
    assert read_unit(tmp_path / "unit.json").scale.sd == 0.0


def test_force_has_the_spread_of_drawn_forces_along_and_across_the_wall() -> None:
    root = np.array([[0.3, 0.0, 0.0], [0.1, 0.2, 0.0], [-0.1, 0.05, 0.25]])
    force = Force(np.array([3.0, -2.0, 5.0]), root @ root.T, TURN[:, 2])
    drawn = force.vector + np.random.default_rng(4).normal(size=(200_000, 3)) @ root.T
    along = drawn @ force.normal
    across = np.linalg.norm(drawn - along[:, None] * force.normal, axis=1)
    assert force.normal_force == pytest.approx((along.mean(), along.std()), rel=5e-3)
    assert force.tangential_force == pytest.approx((across.mean(), across.std()), rel=1e-2)
    assert ScalarEstimate(0.0, 2.0).half_width == pytest.approx(2.0 * stats.norm.ppf(0.95), rel=1e-4)


def test_a_force_straight_on_the_wall_has_no_tangential_force_but_its_greatest_spread() -> None:
    straight = Force(np.array([0.0, 0.0, 4.0]), np.diag([0.01, 0.04, 0.0009]), np.array([0.0, 0.0, 1.0]))
    assert straight.normal_force == pytest.approx((4.0, 0.03))
    assert straight.tangential_force == pytest.approx((0.0, 0.2))


def test_a_scaled_force_has_the_spread_of_scale_and_design() -> None:
    rng, root = np.random.default_rng(5), np.diag([0.1, 0.2, 0.3])
    vector, scale = np.array([3.0, -2.0, 5.0]), ScalarEstimate(1.4, 0.05)
    found, covariance = scale_force(vector, root @ root, scale)
    factor = 1.4 + np.hypot(0.05, 0.01 * 1.4) * rng.normal(size=300_000)
    drawn = 1.4 * (rng.normal(size=(300_000, 3)) @ root) + factor[:, None] * vector
    assert found == pytest.approx(1.4 * vector)
    assert covariance == pytest.approx(np.cov(drawn.T), rel=0.02, abs=2e-3)


def test_a_predicted_force_is_turned_with_its_intervals() -> None:
    tolerance = ToleranceSpec(modulus=0.0)
    parts, half_width = np.array([0.4, -0.3, 2.0]), stats.norm.ppf(0.95) * np.array([0.1, 0.2, 0.5])
    force = predict_force(parts, half_width, TURN, tolerance)
    assert TURN.T @ force.vector == pytest.approx(parts)
    assert TURN.T @ force.covariance @ TURN == pytest.approx(
        np.diag([0.01, 0.04, 0.25]) + 1e-4 * np.outer(parts, parts), rel=1e-3, abs=1e-9
    )
    assert force.normal_force.value == pytest.approx(2.0)
    assert force.tangential_force.value == pytest.approx(0.5)


def test_readings_of_a_load_cell_give_the_most_probable_scale() -> None:
    """Against the maximum of the posterior density, found by a search."""
    before, cell_sd = ScalarEstimate(1.0, 0.05), 0.02
    expected = [ScalarEstimate(2.0, 0.04), ScalarEstimate(0.5, 0.03), ScalarEstimate(1.0, 0.01)]
    cells = [2.1, 0.49, np.nan]

    def cost(scale: float) -> float:
        total = ((scale - before.value) / before.sd) ** 2
        for force, cell in zip(expected[:2], cells[:2], strict=True):
            sd = np.hypot(cell_sd, force.sd * cell / force.value)
            total += ((scale * force.value - cell) / sd) ** 2
        return total

    found = update_stiffness_scale(before, expected, cells, cell_sd)
    assert found.value == pytest.approx(optimize.minimize_scalar(cost, bracket=(0.9, 1.1)).x, rel=1e-6)
    h = 1e-3
    bent = (cost(found.value + h) - 2 * cost(found.value) + cost(found.value - h)) / h**2 / 2
    assert found.sd**2 == pytest.approx(1 / bent + 0.01**2 / 2, rel=1e-5)
    assert update_stiffness_scale(before, expected, [np.nan] * 3, cell_sd) is before


@pytest.mark.parametrize(("force", "cell"), [(1.0, 0.0), (0.0, 1.0), (1.0, -1.0), (-1.0, 1.0)])
def test_a_force_that_is_not_positive_is_refused(force: float, cell: float) -> None:
    with refused("force-not-positive"):
        update_stiffness_scale(ScalarEstimate(1.0, 0.1), [ScalarEstimate(force, 0.1)], [cell], 0.01)


@pytest.mark.parametrize("side", [-1, 1])
def test_readings_six_standard_deviations_from_the_prior_are_the_last_believed(side: int) -> None:
    before, one = ScalarEstimate(1.0, 0.05), [ScalarEstimate(1.0, 0.01)] * 3
    reach = 6.0 * np.hypot(0.05, 0.01)
    update_stiffness_scale(before, one, [1.0 + 0.999 * side * reach] * 3, 0.01)
    with refused("load-cell-scale-off"):
        update_stiffness_scale(before, one, [1.0 + 1.001 * side * reach] * 3, 0.01)


def test_calibration_presses_alternate_between_two_tilts_and_turn_by_two_fifths() -> None:
    poses = [calibration_pose(number, 10.0) for number in range(5)]
    assert [tilt for tilt, _ in poses] == pytest.approx([3.5, 8.0, 3.5, 8.0, 3.5])
    assert [turn % 360 for _, turn in poses] == pytest.approx([0, 144, 288, 72, 216])


def test_sums_by_group_are_those_of_a_loop() -> None:
    rng, group = np.random.default_rng(6), np.array([2, 0, 2, 3, 0, 2])
    left, right = rng.normal(size=(6, 2, 3)), rng.normal(size=(6, 2, 4))
    left[1, 0, 2] = right[4, 1, 0] = np.nan
    found = np.zeros((4, 3, 4))
    for marker, number in enumerate(group):
        for axis in range(2):
            for i in range(3):
                for j in range(4):
                    term = left[marker, axis, i] * right[marker, axis, j]
                    found[number, i, j] += 0.0 if np.isnan(term) else term
    assert sum_by_group(left, right, group) == pytest.approx(found)


def test_weights_are_those_of_students_distribution_and_of_its_median() -> None:
    """The weight of a residual is the slope of the cost over the residual, here of scipy's density."""
    left, variance = np.array([0.3, -0.2, 1.5, 2.0, -0.1, 0.1]), np.array([1.0, 4.0, 0.5])
    small = stats.multivariate_t(shape=np.eye(2), df=FREEDOM)

    def cost(x: np.ndarray, of: float) -> float:
        return -float(small.logpdf(x / np.sqrt(of)))

    for marker, weight in enumerate(robust_weights(left, variance).reshape(3, 2)):
        x, h = left.reshape(3, 2)[marker], 1e-5
        slope = [(cost(x + h * e, variance[marker]) - cost(x - h * e, variance[marker])) / (2 * h) for e in np.eye(2)]
        assert weight == pytest.approx(slope / x, rel=1e-4)
    bad = 50.0 * np.random.default_rng(7).normal(size=2000)
    assert np.median(robust_weights(bad, 1.0)) == pytest.approx((FREEDOM + 2) / (FREEDOM + 2 * np.log(2)), rel=1e-3)
    assert robust_weights(np.empty(0), 1.0).shape == (0,)


LEANING = {"offset_x": 1.0, "offset_y": -2.0, "tilt_x_deg": 4.0, "tilt_y_deg": -3.0, "roll_deg": 20.0}
POINTS = np.array([[0.0, 0.0, 20.0], [8.0, 1.0, 15.0], [-2.0, 8.0, 15.0], [-5.0, 3.0, 10.0]])


@pytest.mark.parametrize("window", [None, WindowSpec(thickness=3.0)])
def test_derivatives_by_the_camera_are_those_of_differences(window: WindowSpec | None) -> None:
    spec = CameraSpec(**LEANING, fy_px=310.0, distortion=(-0.1, 0.02, 0.001, -0.002, 0.0), window=window)
    belief = replace(posterior(), nominal=spec)

    def pair(name: str, step: float) -> tuple[Camera, Camera]:
        return belief.camera(**{name: step}), belief.camera(**{name: -step})

    steps = np.array([1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2, 1e-4, 1e-2, 1e-2, 1e-4])
    cameras = [pair(name, step) for name, step in zip(CAMERA_PARAMETERS, steps, strict=True)]
    camera, by_point = belief.camera(), np.random.default_rng(3).normal(size=(len(POINTS), 3, 10))
    derivatives = CameraDerivatives(camera, cameras, steps)
    rows = []
    for number, (name, step) in enumerate(zip(CAMERA_PARAMETERS, 3.0 * steps, strict=True)):
        moved = 3.0 * steps[number] * by_point[..., number]
        high, low = pair(name, step)
        plain = (high.project(POINTS) - low.project(POINTS)) / (2 * step)
        carried = (high.project(POINTS + moved) - low.project(POINTS - moved)) / (2 * step)
        rows.append((plain, carried))
    plain, carried = (np.stack(each, axis=-1) for each in zip(*rows, strict=True))
    assert derivatives.jacobian(POINTS) == pytest.approx(plain, rel=2e-3, abs=2e-3)
    assert derivatives.jacobian(POINTS, carried=by_point) == pytest.approx(carried, rel=2e-3, abs=5e-3)
    shown = project_with_jacobian(camera, POINTS)
    assert derivatives.jacobian(POINTS, shown) == pytest.approx(derivatives.jacobian(POINTS))
    h = 1e-3
    slope = [(camera.project(POINTS + h * e) - camera.project(POINTS - h * e)) / (2 * h) for e in np.eye(3)]
    assert shown.by_point == pytest.approx(np.stack(slope, axis=-1), rel=1e-3, abs=1e-3)
    assert build_camera(spec).project(POINTS) == pytest.approx(shown.pixels)
