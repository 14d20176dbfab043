"""Scores, scales, offsets and corrections of learning by hand, by scipy and by limits from both sides."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import optimize
from scipy.spatial.distance import cdist

from errors import refused
from palpate.core import ArtefactStore, MissingExtraError, PalpateError
from palpate.core.run import Progress
from palpate.design import TILT_SPACE
from palpate.learn.error_scale import fit_scale, image_features
from palpate.learn.fine_tune import PretrainedModel, fine_tune_members, transfer_estimator
from palpate.learn.interval import Interval, TrainedRange, press_quantile
from palpate.learn.learning_curve import CurvePoint, compute_learning_curve, extrapolate_learning_curve
from palpate.learn.member import MarkerNetwork, MarkerProcess, MarkerRidge, TrainingRun
from palpate.learn.metrics import measure_errors
from palpate.learn.preprocess import Preprocessor, choose_preprocessor, first_duplicate, preprocess_images
from palpate.learn.recording_model import RecordedModel
from palpate.learn.ridge import solve_ridge
from palpate.learn.row_offset import find_row_offset
from palpate.learn.training_set import TrainingSet, flat_features
from palpate.vision import ObservedLayout

RNG = np.random.default_rng(12)
RANGE = TrainedRange(
    centre=np.array([1.0, 2.0, 3.0]),
    directions=np.eye(3)[:, :2],
    low=np.array([-2.0, -1.0]),
    high=np.array([3.0, 4.0]),
    noise_px=0.5,
    rest_mean_px=0.2,
    rest_sd_px=0.1,
    tilt_deg=10.0,
    min_depth_mm=1.0,
    max_depth_mm=5.0,
    threshold=2.0,
    false_alarm=0.01,
)
INSIDE = np.array([0.0, 0.0, 3.0])


@pytest.mark.parametrize(
    ("moved", "pose", "score"),
    [
        ((-4.0, 0.0, 0.0), INSIDE, 4.0),
        ((4.5, 0.0, 0.0), INSIDE, 3.0),
        ((0.0, -3.0, 0.0), INSIDE, 4.0),
        ((0.0, 6.0, 0.0), INSIDE, 4.0),
        ((0.0, 0.0, 1.0), INSIDE, (1 / np.sqrt(3) - 0.2) / 0.1),
        ((0.0, 0.0, 0.0), (9.0, 12.0, 3.0), 5.0 / np.sqrt((1 + 9) / 2)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0 / 2.0),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 9.0), 4.0 / 2.0),
    ],
)
def test_the_score_of_an_image_is_its_greatest_excess(moved: tuple, pose: tuple, score: float) -> None:
    found = RANGE.score(RANGE.centre + np.array([moved]), np.array([pose]), np.array([[1.0, 3.0, 2.0]]))
    assert found == pytest.approx([score])


def test_half_widths_add_the_spread_of_members_and_the_error_at_the_depth() -> None:
    interval = Interval(
        0.9, np.array([2.0, 3.0, 4.0]), np.array([1.0, 3.0]), np.array([[0.1, 0.2, 0.3], [0.3, 0.6, 0.5]]), RANGE, ()
    )
    members = np.array([[[1.0, 2.0, 1.5]], [[3.0, 2.0, 2.5]]])
    at_two = np.array([0.2, 0.4, 0.4])
    wanted = np.sqrt(np.array([1.0, 0.0, 0.25]) + at_two**2)
    assert interval.scale(members)[0] == pytest.approx(wanted)
    assert interval.half_width(members)[0] == pytest.approx([2, 3, 4] * wanted)
    below = members - [0.0, 0.0, 5.0]
    assert interval.scale(below)[0, 0] == pytest.approx(np.sqrt(1.0 + 0.1**2))
    far = RANGE.centre + np.array([[-3.0 - 1e-6, 0.0, 0.0]])
    assert interval.is_out_of_distribution(far, members).tolist() == [True]
    assert interval.is_out_of_distribution(far + 2e-6, members).tolist() == [False]


def test_the_quantile_of_presses_is_that_of_weighted_images() -> None:
    """Three presses of unequal size: each has the weight 1/4, shared by its images."""
    scores, press = np.array([5.0, 1.0, 2.0, 3.0, 4.0]), np.array([7, 7, 9, 9, 2])
    order = sorted(zip(scores, np.where(press == 2, 1 / 4, 1 / 8), strict=True))
    for level in (0.1, 0.125, 0.3, 0.5, 0.625, 0.74):
        total, wanted = 0.0, np.inf
        for score, weight in order:
            total += weight
            if total >= level - 1e-12:
                wanted = score
                break
        assert press_quantile(scores, press, level) == wanted
    assert np.isinf(press_quantile(scores, press, 0.76))
    both = press_quantile(np.column_stack([scores, -scores]), press, 0.5)
    assert both.tolist() == [press_quantile(scores, press, 0.5), press_quantile(-scores, press, 0.5)]


def test_features_of_an_image_are_its_place_in_the_range_and_logarithms() -> None:
    low, high = np.array([-10.0, 0.0]), np.array([10.0, 4.0])
    found = image_features(
        np.array([[5.0, 1.0]]), low, high, np.array([3.0]), np.array([0.9]), np.array([[2.0, 0.4]])
    )
    assert found[0] == pytest.approx([0.5, -0.5, 0.25, 0.25, np.log(4), np.log(1.0), np.log(0.1 + 1e-4)])


def test_the_scale_of_errors_is_the_most_probable_one() -> None:
    """Against a general search of the penalised likelihood."""
    features = RNG.normal(size=(300, 2))
    errors = np.exp(0.3 + 0.8 * features[:, :1]) * RNG.normal(size=(300, 1))
    press = np.arange(300) % 60
    _, scale = fit_scale(features, errors, press, 0.9)
    assert scale is not None
    x = np.clip((features - features.mean(axis=0)) / features.std(axis=0), -3, 3)

    def cost(weights: np.ndarray) -> float:
        log_variance = weights[0] + x @ weights[1:]
        return float(
            np.sum(0.5 * (log_variance + errors[:, 0] ** 2 / np.exp(log_variance))) + 2.0 * np.sum(weights[1:] ** 2)
        )

    best = optimize.minimize(cost, np.zeros(3), method="BFGS", options={"gtol": 1e-9}).x
    assert scale.weights[:, 0] == pytest.approx(best, abs=1e-3)
    assert scale.expected(features)[:, 0] == pytest.approx(np.exp(0.5 * (best[0] + x @ best[1:])), rel=1e-3)


@pytest.mark.parametrize(("images", "presses", "scaled"), [(100, 50, True), (99, 50, False), (100, 49, False)])
def test_few_images_or_presses_have_one_width(images: int, presses: int, scaled: bool) -> None:
    rng = np.random.default_rng(2)
    errors, press = rng.normal(size=(images, 2)), np.arange(images) % presses
    factor, scale = fit_scale(rng.normal(size=(images, 3)), errors, press, 0.9)
    assert (scale is not None) == scaled
    if not scaled:
        assert factor == pytest.approx(press_quantile(np.abs(errors), press, 0.9))


@pytest.mark.parametrize("shift", [-3, -1, 2, 0, 4])
def test_rows_that_are_off_by_up_to_three_are_found(shift: int) -> None:
    rng = np.random.default_rng(4)
    poses = rng.normal(size=(90, 2))
    features = poses @ rng.normal(size=(2, 12)) + 0.05 * rng.normal(size=(90, 12))
    train = np.arange(90) % 3 > 0
    assert find_row_offset(features, np.roll(poses, -shift, axis=0), train) == (shift if abs(shift) < 4 else 0)


def test_ridge_minimises_squares_and_penalty_of_each_input() -> None:
    inputs, targets = RNG.normal(size=(30, 4)) + 3.0, RNG.normal(size=(30, 2))
    penalty = np.array([0.0, 1.0, 5.0, 100.0])
    [(weight, bias)] = solve_ridge(inputs, targets, [penalty])
    rows = np.vstack(
        [np.column_stack([inputs, np.ones(30)]), np.column_stack([np.diag(np.sqrt(penalty)), np.zeros(4)])]
    )
    both = np.linalg.lstsq(rows, np.vstack([targets, np.zeros((4, 2))]), rcond=None)[0]
    assert np.vstack([weight, bias]) == pytest.approx(both)


def lesson(count: int = 40) -> TrainingSet:
    rng = np.random.default_rng(7)
    inputs = rng.normal(size=(count, 5, 2))
    targets = inputs.reshape(count, -1) @ rng.normal(size=(10, 3)) + [1.0, 5.0, 9.0]
    part = np.arange(count) % 4
    return TrainingSet(inputs, targets, part > 1, part == 1, 0, None, 0, np.arange(count) // 2)


def test_a_training_set_scales_by_its_training_samples_alone() -> None:
    samples = lesson()
    own = samples.targets[samples.train]
    assert samples.scale[0] == pytest.approx(own.mean(axis=0))
    assert samples.scale[1] == pytest.approx(own.std(axis=0))
    assert samples.standardised[samples.train].std(axis=0) == pytest.approx(np.ones(3))
    off = samples.targets[samples.validation] + 2.0 * samples.scale[1]
    assert samples.error(off) == pytest.approx(2.0)
    assert replace(samples, validation=np.zeros(40, bool)).chosen_by.tolist() == samples.train.tolist()
    assert replace(samples, press=None).press_numbers.tolist() == list(range(40))
    assert replace(samples, auxiliary=2).n_outputs == 1
    flat = samples.targets.copy()
    flat[:, 1] = 3.0
    assert replace(samples, targets=flat).scale[1][1] == 1.0


def test_small_images_keep_their_shape_and_levels() -> None:
    images = np.full((2, 30, 60), 51, np.uint8)
    images[1] = 255
    found = flat_features(images, 16)
    assert found.shape == (2, 8 * 16)
    assert found.mean(axis=1) == pytest.approx([0.2, 1.0])
    moved = RNG.normal(size=(3, 4, 2))
    assert flat_features(moved, None) == pytest.approx(moved.reshape(3, 8), rel=1e-6)


def test_ridge_on_markers_recovers_a_linear_map_and_chooses_by_the_validation_samples() -> None:
    samples = lesson()
    model = MarkerRidge.train("ridge", samples, TrainingRun())
    assert model.predict(samples.inputs) == pytest.approx(samples.targets, abs=0.02)
    noisy = replace(samples, targets=np.where(samples.train[:, None], RNG.normal(size=(40, 3)), 0.0))
    chosen = MarkerRidge.train("ridge", noisy, TrainingRun())
    free = solve_ridge(flat_features(noisy.inputs, None)[noisy.train], noisy.targets[noisy.train], [1e-9])[0]
    assert np.abs(chosen.arrays["weight"]).sum() < 0.2 * np.abs(free[0]).sum()


def linear_network(turn: np.ndarray, shift: np.ndarray) -> MarkerNetwork:
    """A network without hidden layer on displacements: y = x · turn + shift."""
    size = len(turn)
    return MarkerNetwork(
        "dots-network",
        {
            "projection": np.eye(size),
            "offset": np.zeros(size),
            "weight_0": np.asarray(turn, float)[None],
            "bias_0": np.zeros((1, turn.shape[1])),
            "mean": np.asarray(shift, float),
            "sd": np.ones(turn.shape[1]),
        },
    )


GRID = np.stack(np.meshgrid(np.arange(6.0), np.arange(5.0)), axis=-1).reshape(-1, 2) * 12.0 + 40.0


def prepared(
    rest: np.ndarray, axes: tuple[tuple[str, str], ...] = (("rx", "deg"), ("depth", "mm"))
) -> SimpleNamespace:
    poses = tuple(SimpleNamespace(axis=axis, unit=unit) for axis, unit in axes)
    return SimpleNamespace(
        assigned=SimpleNamespace(layout=ObservedLayout(rest)),
        recording=SimpleNamespace(poses=poses),
        eye=SimpleNamespace(shape=(160, 200)),
    )


def test_an_estimator_is_carried_to_another_camera_by_the_map_between_both_rest_images() -> None:
    rng = np.random.default_rng(5)
    turn, shift = rng.normal(size=(60, 3)), np.array([1.0, 2.0, 3.0])
    network = linear_network(turn, shift)
    start = PretrainedModel("other.h5", ObservedLayout(GRID), network, ("rx_deg", "ry_deg", "depth_mm"))
    c, s = np.cos(0.06), np.sin(0.06)
    view = 1.4 * np.array([[c, -s], [s, c]])
    order = rng.permutation(30)
    own_rest = (GRID @ view.T + [15.0, -9.0])[order]
    carried = transfer_estimator(start, prepared(own_rest))
    moved = rng.normal(size=(4, 30, 2))
    seen = (moved @ view.T)[:, order]
    both = network.predict(moved)
    assert both == pytest.approx(moved.reshape(4, -1) @ turn + shift)
    assert carried.predict(seen) == pytest.approx(both[:, [0, 2]], abs=1e-6)


def test_an_estimator_of_another_make_is_refused() -> None:
    start = PretrainedModel(
        "other.h5", ObservedLayout(GRID), linear_network(np.ones((60, 2)), np.zeros(2)), ("rx_deg", "depth_mm")
    )
    transfer_estimator(start, prepared(GRID * 2.49))
    for factor in (2.51, 1 / 2.51):
        with refused("rest-markers-density", "other.h5", f"{factor:.2g}"):
            transfer_estimator(start, prepared(GRID * factor))
    with refused("model-outputs-differ", "rx_deg", "rz_deg"):
        transfer_estimator(start, prepared(GRID, (("rx", "deg"), ("rz", "deg"))))
    scattered = np.random.default_rng(1).uniform(40, 100, (30, 2))
    with refused("rest-markers-differ", "other.h5"):
        transfer_estimator(start, prepared(scattered))
    with refused("recording-markers-unassigned"):
        fine_tune_members(start, SimpleNamespace(assigned=None), Progress())


def test_the_learning_curve_takes_the_first_presses_and_the_best_member() -> None:
    samples = lesson(120)
    test, counts = np.arange(120) % 4 == 0, []

    def train(some: TrainingSet, count: int):
        counts.append((count, len(np.unique(some.press_numbers[some.train]))))
        yield linear_network(np.zeros((10, 3)), samples.targets.mean(axis=0))
        yield MarkerRidge.train("dots-ridge", some, TrainingRun())

    points = compute_learning_curve(samples, samples.press_numbers, test, train)
    assert counts == [(10, 10), (30, 30)]
    assert [(point.presses, point.estimator) for point in points] == [(n, "dots-ridge") for n in (10, 30)]
    assert points[-1].rmse == pytest.approx((0, 0, 0), abs=0.05)


@pytest.mark.parametrize(
    ("last", "says"),
    [
        (0.5, ("fell by 50%", "29%", "would pay")),
        (0.91, ("fell by 9%", "5%", "nearly")),
        (0.99, ("fell by 1%", "is enough")),
        (1.2, ("rose by 20%",)),
    ],
)
def test_a_curve_is_continued_by_its_last_power(last: float, says: tuple[str, ...]) -> None:
    """A fall to the share s over four times the presses: twice as many give a share √s."""
    points = [CurvePoint(n, "a", (2.0 * error,) * 3) for n, error in ((5, 3.0), (10, 1.0), (40, last))]
    text = extrapolate_learning_curve(points)
    assert text.startswith("From 10 to 40 presses")
    assert all(word in text for word in says), text
    assert extrapolate_learning_curve(points[:1]) == ""


def test_estimates_and_poses_have_one_shape() -> None:
    with refused("estimates-shape", "(2, 3)", "(3, 3)"):
        measure_errors(np.zeros((2, 3)), np.zeros((3, 3)))


@pytest.mark.parametrize(
    ("tilts", "intervals"),
    [((0.0, 2.0, 3.9), [(0, 2), (2, 4)]), ((2.0,), [(0, 2)]), ((0.0, 4.0, 4.1), [(0, 2), (4, 6)])],
)
def test_an_interval_of_tilts_includes_its_lower_end_and_the_last_both(tilts: tuple, intervals: list) -> None:
    poses = np.column_stack([tilts, np.zeros(len(tilts)), np.ones(len(tilts))])
    found = measure_errors(poses + 0.5, poses, TILT_SPACE)
    assert [(part.from_deg, part.to_deg) for part in found.by_tilt] == intervals
    assert sum(part.images for part in found.by_tilt) == len(tilts)


def test_images_of_any_depth_become_grey_levels_of_eight_bit() -> None:
    eye = Preprocessor((16, 24), None, (16, 24), False)
    level = np.linspace(0, 1, 16 * 24).reshape(16, 24)
    wanted = np.floor(255 * level)
    for top, kind in ((1.0, float), (255, np.uint8), (4095, np.uint16), (65535, np.uint16), (1000.0, float)):
        given = (level * top).astype(kind)
        white = 4095 if top == 1000.0 else top
        assert eye.extract(given)[0] == pytest.approx(np.floor(255 * (given / white)), abs=1)
    assert eye.extract((255 * level).astype(np.uint8))[0] == pytest.approx(wanted, abs=1)
    colours = np.zeros((16, 24, 3), np.uint8)
    for channel, weight in enumerate((0.114, 0.587, 0.299)):
        one = colours.copy()
        one[..., channel] = 200
        assert eye.extract(one)[0] == pytest.approx(200 * weight, abs=1)
    assert eye.extract(np.eye(16, 24, dtype=np.uint8))[0].max() == 255
    assert eye.extract(np.full((16, 24, 1), 7, np.uint8))[0].max() == 7
    found, dots = eye.extract(np.zeros((16, 24), np.uint8))
    assert (found.shape, dots.shape) == ((16, 24), (0, 2))


@pytest.mark.parametrize("shape", [(16,), (16, 24, 2), (16, 24, 5), (1, 16, 24, 3)])
def test_an_array_of_another_shape_is_no_image(shape: tuple[int, ...]) -> None:
    with refused("image-shape-wrong", str(shape)):
        Preprocessor((16, 24), None, (16, 24), False).extract(np.zeros(shape, np.uint8))


def test_images_have_eight_pixels_a_side_or_more_and_one_size() -> None:
    Preprocessor((8, 8), None, (8, 8), False).extract(np.zeros((8, 8), np.uint8))
    with refused("image-size-out-of-bounds", 7, 8):
        Preprocessor((8, 7), None, (8, 7), False).extract(np.zeros((8, 7), np.uint8))
    with refused("image-size-out-of-bounds"):
        Preprocessor((8, 7), None, (8, 7), False).extract(np.broadcast_to(np.uint8(0), (6400, 6400)))
    with refused("image-size-changed", "24", "16"):
        Preprocessor((8, 8), None, (8, 8), False).extract(np.zeros((16, 24), np.uint8))


def test_the_first_image_with_the_same_pixels_is_named_and_an_unreadable_one_is_itself() -> None:
    assert first_duplicate(np.array(["b", "a", "", "b", "", "a", "c"])).tolist() == [0, 1, 2, 0, 4, 1, 6]


def test_outputs_of_processes_are_turned_and_shifted_and_errors_are_added() -> None:
    samples = lesson(24)
    process = MarkerProcess.train("dots-process", samples, TrainingRun())
    turn, shift = np.array([[1.0, 0.5], [0.0, 2.0], [-1.0, 0.0]]), np.array([3.0, -4.0])
    whole = process.predict(samples.inputs)
    turned = process.transform_outputs("turned", turn, shift)
    assert turned.predict(samples.inputs) == pytest.approx(whole @ turn + shift)
    again = turned.transform_outputs("again", np.array([[2.0], [1.0]]), np.array([1.0]))
    assert again.predict(samples.inputs) == pytest.approx((whole @ turn + shift) @ [[2.0], [1.0]] + 1.0)
    other = replace(samples, targets=samples.targets + np.array([2.0, -1.0, 0.5]))
    tuned = process.fine_tune("tuned", other)
    before = np.abs(process.predict(other.inputs) - other.targets)[other.train].mean()
    assert np.abs(tuned.predict(other.inputs) - other.targets)[other.train].mean() < 0.3 * before
    mapped = process.transform_inputs(np.eye(10)[::-1])
    assert mapped.predict(samples.inputs.reshape(24, -1)[:, ::-1].reshape(24, 5, 2)) == pytest.approx(whole)


def unreadable(error: PalpateError, count: int = 3) -> SimpleNamespace:
    """A recording none of whose images can be read."""
    images = SimpleNamespace(read=lambda numbers: [error for _ in numbers], stamp=str)

    class Recording(SimpleNamespace):
        def __len__(self) -> int:
            return count

    return Recording(images=images, rest=0)


def test_a_recording_without_a_readable_image_is_refused_by_the_first_reason(tmp_path: Path) -> None:
    damaged = PalpateError("The file 7 is damaged.", "Copy it again.", code="image-unreadable")
    with refused("images-unreadable", "7 is damaged"):
        choose_preprocessor(unreadable(damaged), 64)
    with refused("extra-missing", "OpenCV"):
        choose_preprocessor(unreadable(MissingExtraError("OpenCV", "vision")), 64)
    eye = Preprocessor((16, 24), None, (16, 24), False)
    with refused("images-unreadable", "7 is damaged"):
        preprocess_images(unreadable(damaged), eye, ArtefactStore(tmp_path), Progress())


def test_the_distance_of_an_image_is_that_from_the_nearest_of_the_bank() -> None:
    rng = np.random.default_rng(13)
    bank, moved = rng.normal(size=(6, 4, 2)), rng.normal(size=(3, 4, 2))
    none = np.zeros((0, 0))
    eye = Preprocessor((16, 24), None, (16, 24), False)
    model = RecordedModel(eye, None, (bank, none, none, none), {}, None, None, np.zeros(3), (), {})
    apart = cdist(moved.reshape(3, 8), bank.reshape(6, 8)) / np.sqrt(8)
    assert model.nearest_px(moved) == pytest.approx(apart.min(axis=1))
    own = cdist(bank.reshape(6, 8), bank.reshape(6, 8)) / np.sqrt(8) + np.diag(np.full(6, np.inf))
    assert model.reach_px == pytest.approx(2.0 * own.min(axis=1).max())
    empty = replace(model, reference_bank=(np.zeros((0, 4, 2)), none, none, none))
    assert empty.nearest_px(moved).tolist() == [0.0, 0.0, 0.0]
    assert np.isinf(replace(model, reference_bank=(bank[:1], none, none, none)).reach_px)
