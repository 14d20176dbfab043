"""Pose of a camera, distortion of a print and the assignment behind a press: each recovered from a drawn truth."""

from dataclasses import replace

import numpy as np
import pytest

from errors import refused
from palpate.camera import CameraSpec, build_camera, flat_marker_outlines, project_markers
from palpate.design import DomeSpec, MarkerLayout, MarkerSpec, build_skin, place_markers
from palpate.vision.assign_markers import MarkerAssignment
from palpate.vision.disambiguate_by_press import disambiguate_by_press
from palpate.vision.print_distortion import fit_print_distortion
from palpate.vision.register import CENTRE_SD_PX, FOCAL_SD, register_dome
from palpate.vision.rings import find_rings

SKIN = build_skin(DomeSpec(height=20, thickness=2))
LAYOUT = place_markers(SKIN, MarkerSpec(count=37))
POSE = {"offset_x": 1.2, "offset_y": -0.7, "distance": 49.0, "tilt_x_deg": 2.0, "tilt_y_deg": -1.5, "roll_deg": 7.0}
TRUE = CameraSpec(**POSE)
COUNT = len(LAYOUT)


def shown(spec: CameraSpec = TRUE, layout: MarkerLayout = LAYOUT) -> np.ndarray:
    """Centres of the images of the printed discs."""
    normals = SKIN.normal(layout.positions)
    edges = flat_marker_outlines(layout.positions, normals, layout.diameter)
    return project_markers(build_camera(spec), edges).centres


def named(pixels: np.ndarray, found: np.ndarray | None = None, **changes: object) -> MarkerAssignment:
    found = np.ones(COUNT, bool) if found is None else found
    blob = np.full(COUNT, -1)
    blob[found] = np.arange(found.sum())
    whole = MarkerAssignment(blob, pixels, found, 0.0, False, (), -1, 0.1)
    return replace(whole, **changes)  # type: ignore[arg-type]


def test_the_pose_of_the_camera_is_recovered() -> None:
    found = register_dome(named(shown()), LAYOUT, SKIN)
    assert {name: getattr(found.camera.spec, name) for name in POSE} == pytest.approx(POSE, abs=0.05)
    assert found.rms_px < 0.02
    assert found.reprojection_residual_px == pytest.approx(np.zeros((COUNT, 2)), abs=0.05)
    assert found.distortion is None
    assert np.isnan(found.lens_sd).all()
    assert found.held_rms_px == found.rms_px


def test_a_pattern_that_is_turned_in_the_image_starts_the_roll_there() -> None:
    spec = TRUE.model_copy(update={"roll_deg": -140.0})
    found = register_dome(named(shown(spec), turn_deg=140.0), LAYOUT, SKIN)
    assert found.camera.spec.roll_deg == pytest.approx(-140.0, abs=0.1)
    assert found.rms_px < 0.02


def test_standard_deviations_are_those_of_repeated_noise_and_a_misprint_hardly_matters() -> None:
    rng, poses, told = np.random.default_rng(3), [], []
    for _ in range(40):
        found = register_dome(named(shown() + rng.normal(0, 0.1, (COUNT, 2))), LAYOUT, SKIN, TRUE)
        poses.append([getattr(found.camera.spec, name) for name in POSE])
        told.append(found.sd)
        assert found.rms_px == pytest.approx(0.1 * np.sqrt(2 * (1 - 6 / 74)), rel=0.4)
    assert np.mean(told, axis=0) == pytest.approx(np.std(poses, axis=0), rel=0.35)
    wrong = shown()
    wrong[9] += [6.0, -4.0]
    found = register_dome(named(wrong), LAYOUT, SKIN, TRUE)
    assert found.reprojection_residual_px[9] == pytest.approx([6.0, -4.0], abs=0.6)
    assert found.camera.spec.distance == pytest.approx(49.0, abs=0.3)


def test_missing_markers_have_no_residual() -> None:
    there = np.arange(COUNT) % 3 > 0
    found = register_dome(named(np.where(there[:, None], shown(), 0.0), there), LAYOUT, SKIN)
    assert np.isnan(found.reprojection_residual_px).all(axis=1).tolist() == (~there).tolist()
    assert found.camera.spec.distance == pytest.approx(49.0, abs=0.05)


def test_a_refined_lens_lies_between_calibration_and_image() -> None:
    longer = TRUE.model_copy(update={"fx_px": 1.02 * TRUE.fx_px, "fy_px": 1.02 * TRUE.fy_px, "cx_px": TRUE.cx_px + 3})
    found = register_dome(named(shown(longer)), LAYOUT, SKIN, CameraSpec(), refine_lens=True)
    spec = found.camera.spec
    assert 1.01 * TRUE.fx_px < spec.fx_px < 1.03 * TRUE.fx_px
    assert spec.fy_px / spec.fx_px == pytest.approx(TRUE.fy_px / TRUE.fx_px)
    assert TRUE.cx_px + 1 < spec.cx_px < TRUE.cx_px + 4
    assert found.rms_px < found.held_rms_px
    assert found.lens_sd[0] <= FOCAL_SD
    assert (found.lens_sd[1:3] <= CENTRE_SD_PX).all()
    assert (found.lens_sd > 0).all()


def test_too_few_markers_or_a_mirrored_image_give_no_pose() -> None:
    five = np.arange(COUNT) < 5
    with refused("pose-few-markers", 5, 6):
        register_dome(named(shown(), five), LAYOUT, SKIN)
    register_dome(named(shown(), np.arange(COUNT) % 6 == 1), LAYOUT, SKIN, TRUE)
    with refused("image-mirrored"):
        register_dome(named(shown(), mirrored=True), LAYOUT, SKIN)


def test_another_design_is_refused_by_its_size_or_its_residual() -> None:
    free = replace(LAYOUT, positions=LAYOUT.positions + [[0.02 * (-1) ** k, 0.0, 0.0] for k in range(COUNT)])
    middle = shown().mean(axis=0)
    for scale, word in ((1.3, "large"), (0.75, "small")):
        with refused("layout-misfit-scale", word):
            register_dome(
                named(middle + scale * (shown() - middle) + np.random.default_rng(1).normal(0, 2, (COUNT, 2))),
                free,
                SKIN,
            )
    with refused("layout-misfit"):
        register_dome(named(shown() + np.random.default_rng(1).normal(0, 3, (COUNT, 2))), free, SKIN)


RINGS = find_rings(LAYOUT.positions)


def printed(growth: float, x: float, y: float, along: float, across: float, turn: float, ring: int = 2) -> np.ndarray:
    """Positions of the markers, of which those of a ring are printed larger, aside, elliptical and turned."""
    assert RINGS is not None
    places = LAYOUT.positions.copy()
    own = RINGS.members(ring)
    flat = places[own, :2] * (1 + growth)
    c, s = np.cos(turn), np.sin(turn)
    flat = flat @ np.array([[c, s], [-s, c]]) @ np.array([[1 + along, across], [across, 1 - along]]) + [x, y]
    places[own] = SKIN.inner_point(np.hypot(*flat.T), np.arctan2(flat[:, 1], flat[:, 0]))
    return places


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_distorted_ring_is_recovered_with_its_size_centre_ellipse_and_turn(side: float) -> None:
    assert RINGS is not None
    bent = printed(0.06, 0.3, -0.2, side * 0.015, side * 0.02, 0.03)
    camera = build_camera(TRUE)
    pose = np.array([getattr(TRUE, name) for name in POSE])

    def posed(values: np.ndarray):
        return build_camera(TRUE.model_copy(update=dict(zip(POSE, map(float, values), strict=True))))

    rng = np.random.default_rng(2)
    which = np.arange(COUNT)
    start = pose + rng.normal(0, 0.2, 6)
    found, law = fit_print_distortion(RINGS, (LAYOUT, SKIN), (which, camera.project(bent)), posed, (start, pose))
    assert found == pytest.approx(pose, abs=0.8)
    assert law.rms_px < 0.05
    assert posed(found).project(law.positions) == pytest.approx(camera.project(bent), abs=0.1)
    assert law.growth == pytest.approx([1, 1.06, 1], abs=0.02)
    assert law.radius == pytest.approx(RINGS.rho[1:] * law.growth)
    assert law.greatest == pytest.approx(np.abs(law.growth - 1).max())
    assert law.centre - law.centre[0] == pytest.approx(np.array([[0, 0], [0.3, -0.2], [0, 0]]), abs=0.1)
    assert law.flatness[1] == pytest.approx((1 + 0.025) / (1 - 0.025) - 1, abs=0.01)
    longer = np.degrees(np.arctan2(side * 0.02, side * 0.015)) / 2
    assert law.flat_deg[1] == pytest.approx(longer if side > 0 else longer + 180, abs=6)
    assert law.turn_deg - law.turn_deg[0] == pytest.approx([0, np.degrees(0.03), 0], abs=0.3)


def test_a_print_whose_ring_is_larger_is_registered_with_its_distortion() -> None:
    bent = replace(LAYOUT, positions=printed(0.10, 0.0, 0.0, 0.0, 0.0, 0.0))
    found = register_dome(named(shown(layout=bent)), LAYOUT, SKIN, TRUE)
    assert found.distortion is not None
    assert found.distortion.growth[1] / found.distortion.growth[0] == pytest.approx(1.10, abs=0.02)
    assert found.distortion.rms_px < 0.05 < found.rms_px


def choices() -> tuple[MarkerAssignment, np.ndarray]:
    """Two assignments of a ring of six about a centre, turned by 60°, and the motion of each marker under a press."""
    azimuth = np.radians(60 * np.arange(6))
    rest = 100 + 30 * np.vstack([[0, 0], np.column_stack([np.cos(azimuth), np.sin(azimuth)])])
    every = np.ones(7, bool)
    turn = np.array([0, 2, 3, 4, 5, 6, 1])
    one = MarkerAssignment(np.arange(7), rest, every, 0.0, False, (), -1, 0.1)
    other = MarkerAssignment(turn, rest[turn], every, 60.0, False, (), -1, 0.1)
    motion = np.column_stack([np.linspace(2, 8, 7), np.zeros(7)]) * [[1.0, 0.0]] + [[0.0, k % 3] for k in range(7)]
    return replace(one, alternatives=(other,)), motion


@pytest.mark.parametrize("gain", [0.8, 1.0, 1.3])
@pytest.mark.parametrize("true", [0, 1])
def test_the_press_tells_which_assignment_is_right_and_how_deep_it_was(true: int, gain: float) -> None:
    naming, motion = choices()
    both = (replace(naming, alternatives=()), *naming.alternatives)
    right = both[true]
    pressed = np.empty((7, 2))
    pressed[right.blob] = right.positions_px + gain * motion
    shuffled = pressed[np.random.default_rng(1).permutation(7)]
    found = disambiguate_by_press(naming, np.stack([motion, motion]), shuffled, 30.0)
    assert found.naming.turn_deg == right.turn_deg
    assert not found.naming.ambiguous
    assert found.gain == pytest.approx(gain, abs=1e-6)
    assert found.misfit_px[true] == pytest.approx(0.0, abs=1e-9)
    assert found.misfit_px[1 - true] > 0.5
    assert found.sureness == pytest.approx([0.0, 0.5] if true == 0 else [0.5, 0.0], abs=1e-6)


def test_a_press_that_moves_all_alike_leaves_both_and_a_wrong_or_light_one_is_refused() -> None:
    naming, motion = choices()
    alike = np.tile([3.0, 1.0], (7, 1))
    found = disambiguate_by_press(naming, np.stack([alike, alike]), naming.positions_px + alike, 30.0)
    assert found.naming.ambiguous
    light = motion / np.sqrt(np.mean((motion**2).sum(axis=1)))
    with refused("reference-press-too-light", "0.99"):
        disambiguate_by_press(naming, 0.99 * np.stack([light, light]), naming.positions_px + light, 30.0)
    disambiguate_by_press(naming, 1.01 * np.stack([alike / 3, alike / 3]), naming.positions_px + alike / 3, 30.0)
    for pressed in (naming.positions_px - 3 * motion, naming.positions_px[:2] + motion[:2], np.empty((0, 2))):
        with refused("reference-press-unexplained"):
            disambiguate_by_press(naming, np.stack([motion, motion]), pressed, 30.0)


@pytest.mark.parametrize(("growth", "refused_"), [(0.12, False), (0.4, True)])
def test_a_ring_that_is_wrong_by_more_than_a_fifth_is_of_another_design(growth: float, refused_: bool) -> None:
    bent = replace(LAYOUT, positions=printed(growth, 0.0, 0.0, 0.0, 0.0, 0.0, ring=1))
    if refused_:
        with refused("layout-misfit-rings", "%"):
            register_dome(named(shown(layout=bent)), LAYOUT, SKIN, TRUE)
    else:
        assert register_dome(named(shown(layout=bent)), LAYOUT, SKIN, TRUE).distortion is not None
