"""Motion of markers, layouts at rest, neighbours and grown assignments: polynomials, eigenvalues, brute force."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from errors import refused
from palpate.vision.grow_assignment import (
    assignment_residuals,
    grow_assignment,
    grow_largest,
    mutual_nearest,
    spread_starts,
)
from palpate.vision.match_markers import GRID, Correspondence, MarkerMatcher, MatchFault, marker_descriptor
from palpate.vision.motion import MotionModel, fit_motion_model, interpolate_motion
from palpate.vision.neighbours import agree, largest_group, nearest, nearest_distance
from palpate.vision.observed_layout import ObservedLayout, number_markers

RNG = np.random.default_rng(8)
POINTS = RNG.uniform(0, 100, (40, 2))
PLACES = RNG.uniform(20, 80, (9, 2))
GRID_POINTS = np.stack(np.meshgrid(np.arange(7.0), np.arange(5.0)), axis=-1).reshape(-1, 2) * [10.0, 10.0] + 20.0
SHEAR = np.array([[1.1, 0.25], [-0.15, 0.9]])


def quadratic(points: np.ndarray) -> np.ndarray:
    x, y = points.T / 50
    return np.column_stack(
        [1 + 2 * x - y + 0.5 * x * x - 0.7 * x * y + 0.3 * y * y, -2 + x + 3 * y + 0.9 * y * y - x * x]
    )


def test_a_quadratic_motion_is_interpolated_exactly_and_a_linear_one_of_few_points() -> None:
    assert interpolate_motion(POINTS, quadratic(POINTS), PLACES) == pytest.approx(quadratic(PLACES), abs=2e-4)
    few, linear = POINTS[:8], POINTS @ SHEAR + 3.0
    assert interpolate_motion(few, linear[:8], PLACES) == pytest.approx(PLACES @ SHEAR + 3.0, abs=5e-3)
    assert np.abs(interpolate_motion(few, quadratic(few), PLACES) - quadratic(PLACES)).max() > 0.01
    nine = POINTS[:9]
    assert interpolate_motion(nine, quadratic(nine), nine[:1] + 1) == pytest.approx(quadratic(nine[:1] + 1), abs=5e-3)


def test_fewer_than_four_points_give_their_mean_and_none_gives_none() -> None:
    moved = np.array([[1.0, 2.0], [3.0, 5.0], [5.0, 8.0]])
    assert interpolate_motion(POINTS[:3], moved, PLACES).tolist() == [[3.0, 5.0]] * len(PLACES)
    assert interpolate_motion(POINTS[:0], moved[:0], PLACES).tolist() == [[0.0, 0.0]] * len(PLACES)


def test_a_point_does_not_predict_its_own_place() -> None:
    moved = np.zeros((40, 2))
    moved[5] = 100.0
    assert np.abs(interpolate_motion(POINTS, moved, POINTS[5:6])).max() < 1e-6
    assert np.abs(interpolate_motion(POINTS, moved, POINTS[5:6] + 0.5)).max() > 10.0


def test_the_nearest_points_count_and_the_nearest_of_them_most() -> None:
    line = np.column_stack([np.arange(1.0, 41.0), np.random.default_rng(9).uniform(-0.3, 0.3, 40)])
    step = np.where(np.arange(40) < 14, 0.0, 1.0)[:, None] * np.ones(2)
    assert interpolate_motion(line, step, np.zeros((1, 2))) == pytest.approx(np.zeros((1, 2)), abs=1e-9)
    assert np.abs(interpolate_motion(line[1:], step[1:], np.zeros((1, 2)))).max() > 1e-3


def made_motion(images: int = 60) -> np.ndarray:
    """Displacements of two modes about a mean."""
    rng = np.random.default_rng(9)
    return 5.0 + np.tensordot(rng.normal(size=(images, 2)) * [3.0, 1.0], rng.normal(size=(2, 40, 2)), axes=1)


def test_modes_of_motion_have_the_covariance_of_the_images() -> None:
    moved = made_motion()
    model = fit_motion_model(POINTS, moved)
    assert model.modes_px is not None
    flat = model.modes_px.reshape(len(model.modes_px), -1)
    assert model.mean_px == pytest.approx(moved.mean(axis=0))
    assert flat.T @ flat == pytest.approx(np.cov(moved.reshape(60, -1).T, bias=True), abs=1e-8)
    assert len(flat) == 20
    assert model.noise_px == 0.3
    shaken = moved + np.random.default_rng(9).normal(0, 2.0, moved.shape)
    values = np.linalg.eigvalsh(np.cov(shaken.reshape(60, -1).T, bias=True))[::-1]
    assert fit_motion_model(POINTS, shaken).noise_px ** 2 == pytest.approx(values[20:].mean() * 60 / 80, rel=1e-9)
    assert len(fit_motion_model(POINTS, moved[:2]).modes_px) == 1


def test_a_motion_of_the_modes_is_recovered_from_a_part_and_despite_a_false_marker() -> None:
    moved = made_motion()
    model = fit_motion_model(POINTS, moved, least_noise_px=1e-3)
    model = MotionModel(POINTS, model.modes_px[:2], model.mean_px, 1e-3)
    found = np.arange(40) < 12
    assert model.fit(np.where(found[:, None], moved[7], np.nan), found) == pytest.approx(moved[7], abs=1e-3)
    wrong = moved[7].copy()
    wrong[3] += 40.0
    assert model.fit(wrong, np.ones(40, bool)) == pytest.approx(moved[7], abs=0.5)
    seen = POINTS + np.where(found[:, None], moved[7], np.nan)
    assert model.fill(seen, found) == pytest.approx(POINTS + moved[7], abs=2e-3)


def test_the_most_probable_motion_lies_between_mean_and_markers_by_their_variances() -> None:
    """One mode of variance 4 in one coordinate, of noise 1: 4/5 of the way to the marker."""
    modes = np.zeros((1, 1, 2))
    modes[0, 0, 0] = 2.0
    model = MotionModel(np.zeros((1, 2)), modes, np.array([[1.0, 0.0]]), 1.0)
    weights = []
    for far in (1e-3, 1.0):
        found = model.fit(np.array([[1.0 + far, 0.0]]), np.ones(1, bool))[0, 0] - 1.0
        weights.append(found / far)
    assert weights[0] == pytest.approx(0.8, abs=1e-4)
    assert 0.6 < weights[1] < 0.8
    assert model.fit(np.zeros((1, 2)), np.zeros(1, bool)).tolist() == [[1.0, 0.0]]


def test_without_modes_missing_markers_follow_their_neighbours() -> None:
    found = np.arange(40) % 4 > 0
    seen = POINTS + np.where(found[:, None], quadratic(POINTS), np.nan)
    assert MotionModel(POINTS).fill(seen, found) == pytest.approx(POINTS + quadratic(POINTS), abs=0.01)
    whole = np.ones(40, bool)
    assert MotionModel(POINTS).fill(POINTS + 2.0, whole) == pytest.approx(POINTS + 2.0)


def test_a_grid_has_the_neighbours_spacings_and_smooth_fields_of_a_grid() -> None:
    layout = ObservedLayout(GRID_POINTS)
    apart = cdist(GRID_POINTS, GRID_POINTS)
    for dot, row in enumerate(layout.neighbours):
        near = row[row >= 0]
        far = apart[dot, near]
        assert (np.diff(far) >= 0).all()
        assert {int(k) for k in np.flatnonzero((apart[dot] > 0) & (apart[dot] < 10.5))} <= set(near.tolist())
        assert far.max() < 15
        assert (row[len(near) :] == -1).all()
    assert layout.spacing_px == pytest.approx(np.full(35, 10.0), abs=4.3)
    vectors, rough = layout.harmonics
    graph = np.zeros((35, 35))
    for dot, row in enumerate(layout.neighbours):
        for other in row[row >= 0]:
            graph[dot, other] = graph[other, dot] = 1.0
    laplacian = np.diag(graph.sum(axis=0)) - graph
    values = np.linalg.eigvalsh(laplacian)
    assert rough == pytest.approx(values[:10] / values[-1], abs=1e-9)
    assert vectors.shape == (35, 10)
    assert vectors.T @ vectors == pytest.approx(35 * np.eye(10), abs=1e-8)
    assert laplacian @ vectors == pytest.approx(vectors * (rough * values[-1]), abs=1e-8)


def test_the_spacing_is_the_median_distance_of_the_neighbours() -> None:
    hexagon = np.array([[0.0, 0.0], *(np.array([np.cos(a), np.sin(a)]) for a in np.arange(6) * np.pi / 3)])
    stretched = hexagon * [10.0, 12.0]
    layout = ObservedLayout(stretched)
    near = layout.neighbours[0][layout.neighbours[0] >= 0]
    assert sorted(near.tolist()) == [1, 2, 3, 4, 5, 6]
    assert layout.spacing_px[0] == pytest.approx(np.median(np.linalg.norm(stretched[1:], axis=1)))


def test_a_far_neighbour_of_the_triangulation_is_none() -> None:
    places = np.vstack([GRID_POINTS, [[200.0, 40.0]]])
    layout = ObservedLayout(places)
    assert not (layout.neighbours[:35] == 35).any()
    assert (layout.neighbours[35] >= 0).any()


def test_markers_are_numbered_ring_by_ring_and_by_angle_whatever_their_order() -> None:
    hexagon = np.array(
        [[0.0, 0.0], *(10 * np.array([np.cos(a), np.sin(a)]) for a in np.radians([10, 70, 130, 190, 250, 310]))]
    )
    order = np.random.default_rng(2).permutation(7)
    found = number_markers(hexagon[order] + [50.0, 60.0]).rest_px - [50.0, 60.0]
    assert found[0] == pytest.approx([0, 0], abs=1e-9)
    assert np.degrees(np.arctan2(found[1:, 1], found[1:, 0])) == pytest.approx([-170, -110, -50, 10, 70, 130])


def test_too_few_blobs_or_blobs_on_a_line_make_no_layout() -> None:
    number_markers(POINTS[:6])
    with refused("rest-markers-few", 5, 6):
        number_markers(POINTS[:5])
    with refused("rest-markers-on-line"):
        number_markers(np.column_stack([np.arange(8.0), 2 * np.arange(8.0)]))
    away = np.vstack([GRID_POINTS, [[20.0, 20.0]]])
    with refused("rest-markers-on-line"):
        number_markers(away)


def test_compiled_searches_find_the_nearest() -> None:
    others = np.random.default_rng(9).uniform(0, 100, (25, 2))
    apart = cdist(POINTS, others)
    number, distance = nearest(POINTS, others)
    assert number.tolist() == apart.argmin(axis=1).tolist()
    assert distance == pytest.approx(apart.min(axis=1))
    own = cdist(POINTS, POINTS) + np.diag(np.full(40, np.inf))
    assert nearest_distance(POINTS, 6.0) == pytest.approx(np.minimum(own.min(axis=1), 6.0))
    assert (nearest_distance(POINTS, 6.0) == 6.0).any()


def test_mutual_nearest_neighbours_within_reach_are_assigned() -> None:
    blobs = np.random.default_rng(9).uniform(0, 100, (25, 2))
    apart, reach = cdist(POINTS, blobs), np.linspace(2.0, 12.0, 40)
    wanted = [
        int(k) if apart[:, k].argmin() == i and apart[i, k] < reach[i] else -1
        for i, k in enumerate(apart.argmin(axis=1))
    ]
    assert mutual_nearest(POINTS, cKDTree(blobs), reach).tolist() == wanted
    assert -1 in wanted
    assert len(set(wanted)) > 5


def test_the_largest_connected_group_is_found() -> None:
    wanted = np.array([True] * 6 + [False, True])
    pairs = np.array([[0, 1], [1, 2], [3, 4], [3, 5], [5, 7]])
    assert largest_group(pairs, wanted).tolist() == [False, False, False, True, True, True, False, True]


def test_starts_are_the_most_central_place_and_then_the_most_distant_within_the_limit() -> None:
    usable = np.ones(35, bool)
    centre = GRID_POINTS.mean(axis=0)
    starts = spread_starts(GRID_POINTS, usable, 1.0, 3)
    assert starts[0] == 17
    assert np.linalg.norm(GRID_POINTS[starts[1]] - centre) == pytest.approx(np.hypot(30, 20))
    assert cdist(GRID_POINTS[starts[2:]], GRID_POINTS[starts[:2]]).min() > 30
    inner = spread_starts(GRID_POINTS, usable, 0.5, 40)
    far = np.linalg.norm(GRID_POINTS - centre, axis=1)
    assert sorted(inner) == np.flatnonzero(far <= 0.5 * far.max()).tolist()
    usable[17] = False
    assert spread_starts(GRID_POINTS, usable, 1.0, 1)[0] in (10, 16, 18, 24)


def test_predictions_are_moved_by_the_median_of_their_neighbours() -> None:
    near = np.array([[i, *np.argsort(cdist(GRID_POINTS, GRID_POINTS)[i])[1:5]] for i in range(35)])
    shift = np.array([2.0, -1.5])
    blobs = np.delete(GRID_POINTS + shift, [3, 20], axis=0)
    blobs[5] += [2.0, 0.0]
    found = agree(GRID_POINTS, blobs, near, np.full(35, 5.0), 1)
    assert found == pytest.approx(GRID_POINTS + shift, abs=1e-9)
    far = agree(GRID_POINTS, GRID_POINTS + 200.0, near, np.full(35, 5.0), 3)
    assert far == pytest.approx(GRID_POINTS)
    lone = np.full((35, 1), 3)
    assert agree(GRID_POINTS, blobs, lone, np.full(35, 5.0), 1) == pytest.approx(GRID_POINTS + shift, abs=1e-9)


def sheared(missing: tuple[int, ...] = ()) -> tuple[np.ndarray, np.ndarray]:
    """Blobs of a sheared grid in another order, and the blob of each marker."""
    order = np.random.default_rng(4).permutation([k for k in range(35) if k not in missing])
    truth = np.full(35, -1)
    truth[order] = np.arange(len(order))
    return (GRID_POINTS @ SHEAR.T + 12.0)[order], truth


@pytest.mark.parametrize("missing", [(), (2, 18, 34)])
def test_an_assignment_grows_over_a_sheared_grid_from_one_marker(missing: tuple[int, ...]) -> None:
    blobs, truth = sheared(missing)
    near, start = ObservedLayout(GRID_POINTS).neighbours, np.where(np.arange(35) == 17, truth, -1)
    assert grow_assignment(GRID_POINTS, near, blobs, start, 0.4).tolist() == truth.tolist()
    assert (grow_assignment(GRID_POINTS, near, blobs, start, 0.02) >= 0).sum() < 5
    alone = np.where(np.arange(35) == 17, truth[16], -1)
    starts = [(GRID_POINTS, alone), (GRID_POINTS, start), (GRID_POINTS, start), (GRID_POINTS, np.full(35, -1))]
    found = grow_largest(starts, near, blobs, 0.4, 0.3)
    assert found[0].tolist() == truth.tolist()
    assert len(found) == len({each.tobytes() for each in found})
    assert all((each >= 0).sum() >= 0.3 * 35 for each in found)


def test_a_displaced_blob_is_off_its_prediction_by_its_displacement_over_the_spacing() -> None:
    blobs, truth = sheared()
    near = ObservedLayout(GRID_POINTS).neighbours
    assert assignment_residuals(GRID_POINTS, near, blobs, truth) == pytest.approx(np.zeros(35), abs=0.02)
    blobs[truth[17]] += [3.0, 0.0]
    off = assignment_residuals(GRID_POINTS, near, blobs, truth)
    step = np.mean([np.linalg.norm(SHEAR @ (GRID_POINTS[k] - GRID_POINTS[17])) for k in near[17] if k >= 0])
    assert off[17] == pytest.approx(3.0 / step, rel=0.25)
    assert off.argmax() == 17
    lonely = np.where(np.isin(np.arange(35), [17, *near[17][near[17] >= 0]]), -1, truth)
    lonely[17] = truth[17]
    assert assignment_residuals(GRID_POINTS, near, blobs, lonely)[17] == 0.0
    assert assignment_residuals(GRID_POINTS, near, blobs, lonely)[near[17][0]] == 0.0


def test_the_descriptor_of_a_blob_is_its_cell_smoothed_in_both_directions() -> None:
    shape = (100.0, 200.0)
    found = marker_descriptor(np.array([[70.0, 35.0]]), shape).reshape(GRID, GRID)
    wanted = np.zeros((GRID, GRID))
    wanted[6:9, 6:9] = np.outer([1, 2, 1], [1, 2, 1]) / 6.0
    assert found == pytest.approx(wanted)
    between = marker_descriptor(np.array([[75.0, 37.5]]), shape).reshape(GRID, GRID)
    row = np.convolve([1.0, 1.0], [1, 2, 1])
    assert between[6:10, 6:10] == pytest.approx(np.outer(row, row) / np.linalg.norm(np.outer(row, row)))
    quarter = marker_descriptor(np.array([[72.5, 35.0], [70.0, 35.0]]), shape).reshape(GRID, GRID)
    assert quarter[7, 7] / quarter[7, 8] == pytest.approx((2 + 1.5 + 0.25) / (1 + 0.75 + 0.5))
    assert not marker_descriptor(np.empty((0, 2)), shape).any()
    assert marker_descriptor(POINTS, shape) @ marker_descriptor(POINTS, shape) == pytest.approx(1.0)


@pytest.fixture
def matcher() -> MarkerMatcher:
    return MarkerMatcher(ObservedLayout(GRID_POINTS), (80, 100))


def test_a_grid_that_moved_little_is_assigned_with_its_agreement_and_roughness(matcher: MarkerMatcher) -> None:
    moved = GRID_POINTS + np.array([1.0, -2.0])
    found = matcher.find(moved[::-1])
    assert found.blob.tolist() == list(range(34, -1, -1))
    assert found.moved_px == pytest.approx(np.tile([1.0, -2.0], (35, 1)))
    assert (found.agreement, found.confident, found.accepted) == (1.0, True, True)
    assert found.rough < 1e-3
    lost = matcher.find(np.delete(moved, 17, axis=0))
    assert lost.agreement == pytest.approx(2 * 34 / (35 + 34))
    assert lost.found.sum() == 34
    assert lost.moved_px[17] == pytest.approx([1.0, -2.0], abs=0.05)
    assert matcher.find(GRID_POINTS[:13]).fault is MatchFault.NO_DOTS
    assert matcher.find(GRID_POINTS[:14]).fault is MatchFault.LEFT_OVER


def test_a_matcher_that_expects_no_motion_takes_the_nearest_blob(matcher: MarkerMatcher) -> None:
    matcher.smooth = False
    blobs = np.vstack([GRID_POINTS[::-1] + 1.0, [[500.0, 500.0]]])
    found = matcher.find(blobs)
    assert found.blob.tolist() == list(range(34, -1, -1))
    assert found.moved_px == pytest.approx(np.ones((35, 2)))
    nothing = matcher.find(np.empty((0, 2)))
    assert (nothing.fault, nothing.found.any()) == (MatchFault.NO_DOTS, False)


def test_confident_images_are_remembered_and_the_most_alike_is_the_first_guess(matcher: MarkerMatcher) -> None:
    moves = ([3.0, 0.0], [0.0, 4.0], [-4.0, 2.0])
    for move in moves:
        dots = GRID_POINTS + move
        matcher.remember(dots, Correspondence(np.tile(move, (35, 1)), np.arange(35), 1.0, 0.0, confident=True))
        matcher.remember(dots, Correspondence(np.zeros((35, 2)), np.arange(35), 1.0, 0.0, confident=False))
    assert len(matcher.fields) == 3
    guesses = matcher._alike(GRID_POINTS + moves[1])
    assert guesses[0].tolist() == [moves[1]] * 35


def test_a_matcher_survives_its_arrays(matcher: MarkerMatcher) -> None:
    motion, usual = matcher.to_arrays()
    assert (motion.size, usual.tolist()[2]) == (0, 0.0)
    moved = np.random.default_rng(9).normal(size=(9, 35, 2))
    matcher.motions, matcher.usual = fit_motion_model(GRID_POINTS, moved), (0.9, 0.05)
    again = matcher.with_arrays(*matcher.to_arrays())
    assert again.usual == (0.9, 0.05)
    assert again.motions is not None
    assert again.motions.mean_px == pytest.approx(matcher.motions.mean_px)
    assert again.motions.modes_px == pytest.approx(matcher.motions.modes_px)
    assert again.motions.noise_px == matcher.motions.noise_px
