"""Measures of images and patterns: closed forms of noise, moments, grey levels, fields, patterns and assignments."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from errors import refused
from palpate.vision.assign_markers import assign_markers
from palpate.vision.choose_field import AT_RANDOM, FieldCandidate, choose_dots, choose_fields, is_midpoint, is_printed
from palpate.vision.detector import Detector, inside, to_grey
from palpate.vision.pattern import build_pattern, wrap_deg
from palpate.vision.segment import Blobs, Segments, heights, measure_noise, segment
from palpate.vision.spec import DetectSpec
from palpate.vision.split import split_merged
from palpate.vision.tracker import _assign

RNG = np.random.default_rng(21)


@pytest.mark.parametrize("step", [1, 2])
def test_noise_is_measured_over_a_slope_and_is_at_least_that_of_rounding(step: int) -> None:
    rng = np.random.default_rng(1)
    slope = np.add.outer(0.3 * np.arange(300.0), 0.7 * np.arange(400.0)).astype(np.float32)
    noisy = slope + rng.normal(0, 5.0, slope.shape).astype(np.float32)
    assert measure_noise(noisy, step) == pytest.approx(5.0, rel=0.03)
    assert measure_noise(slope, step) == pytest.approx(1 / np.sqrt(12))
    assert measure_noise(noisy.T.copy(), step) == pytest.approx(5.0, rel=0.03)


def test_noise_of_the_smoothed_image_is_that_of_the_factor() -> None:
    rng = np.random.default_rng(2)
    noisy = rng.normal(100, 4.0, (300, 300)).astype(np.float32)
    for diameter in (6.0, 12.0):
        height, factor = heights(noisy, diameter)
        sigma = max(0.15 * diameter, 0.6)
        grid = np.arange(-20, 21)
        kernel = np.exp(-(grid**2) / (2 * sigma**2))
        kernel /= kernel.sum()
        assert factor == pytest.approx(np.sum(np.outer(kernel, kernel) ** 2) ** 0.5, rel=0.02)
        assert (height >= 0).all()


def segments_of(area: list, spread: list, contrast: list | None = None, border: list | None = None) -> Segments:
    count = len(area)
    return Segments(
        np.zeros((4, 4), np.int32),
        np.array(area, float),
        np.arange(2.0 * count).reshape(count, 2),
        np.array(spread, float),
        np.array(contrast or [50.0] * count),
        np.array(border or [False] * count),
    )


def disc(diameter: float, ratio: float = 1.0, angle: float = 0.4) -> tuple[float, list[float]]:
    """Area and covariance of an ellipse of the area of a disc."""
    a, b = diameter / 2 / np.sqrt(ratio), diameter / 2 * np.sqrt(ratio)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    spread = turn @ np.diag([a * a / 4, b * b / 4]) @ turn.T
    return np.pi * a * b, [spread[0, 0], spread[0, 1], spread[1, 1]]


def test_an_ellipse_has_its_diameter_axis_ratio_and_fullness() -> None:
    (round_, one), (oval, other) = disc(10.0), disc(8.0, 0.5)
    found = segments_of([round_, oval, 0.7 * oval], [one, other, other])
    assert found.diameter_px == pytest.approx([10.0, 8.0, 8.0 * np.sqrt(0.7)])
    assert found.roundness == pytest.approx([1.0, 0.5, 0.5])
    assert found.fullness == pytest.approx([1.0, 1.0, 0.7])


@pytest.mark.parametrize(
    ("size", "ratio", "share", "contrast", "good"),
    [
        (10.0, 1.0, 1.0, 50.0, True),
        (3.9, 1.0, 1.0, 50.0, False),
        (22.1, 1.0, 1.0, 50.0, False),
        (21.9, 1.0, 1.0, 50.0, True),
        (10.0, 0.2, 1.0, 50.0, False),
        (10.0, 1.0, 0.79, 50.0, False),
        (10.0, 1.0, 0.81, 50.0, True),
        (10.0, 1.0, 1.0, 5.0, False),
    ],
)
def test_markers_look_alike_in_size_shape_and_contrast(
    size: float, ratio: float, share: float, contrast: float, good: bool
) -> None:
    area, spread = disc(10.0)
    own_area, own_spread = disc(size, ratio)
    found = segments_of([area] * 5 + [share * own_area], [spread] * 5 + [own_spread], [50.0] * 5 + [contrast])
    chosen = choose_dots(found, 10.0, DetectSpec(evenness=0.3, roundness=0.3))
    assert chosen.tolist() == list(range(5)) + ([5] if good else [])


@pytest.mark.parametrize(("height", "share"), [(30.0, 0.6), (12.0, 0.2)])
def test_blobs_are_cut_at_half_their_height_and_low_ones_are_left_out(height: float, share: float) -> None:
    y, x = np.mgrid[:60, :80]
    image = np.zeros((60, 80), np.float32)
    for column, row, top in ((15, 15, 60.0), (45, 15, 60.0), (15, 42, 60.0), (55, 42, height)):
        image += (top * np.exp(-((x - column) ** 2 + (y - row) ** 2) / (2 * 3.0**2))).astype(np.float32)
    found = segment(image, 8.0, 2.0, 0.4)
    assert len(found.area_px) == (4 if share > 0.4 else 3)
    half = np.pi * 2 * np.log(2) * 3.0**2
    assert found.area_px == pytest.approx(np.full(len(found.area_px), half), rel=0.12)
    assert found.contrast[:2] == pytest.approx([60.0, 60.0], rel=1e-3)
    assert found.middle_px[:2] == pytest.approx(np.array([[15, 15], [45, 15]]), abs=0.05)
    for number in range(len(found.area_px)):
        own = found.labels == number + 1
        assert own.sum() == found.area_px[number]
        assert np.array([x[own].mean(), y[own].mean()]) == pytest.approx(found.middle_px[number])


def test_two_discs_that_touch_are_split_at_their_centres_and_a_long_one_is_not() -> None:
    y, x = np.mgrid[:60, :100].astype(float)
    label, area, middle, spread = np.zeros((60, 100), np.int32), [], [], []
    centres = [(15, 15), (35, 15), (15, 40), (52.0, 40.0), (61.0, 42.0)]
    shapes = [np.hypot(x - u, y - v) < 5 for u, v in centres]
    masks = [*shapes[:3], shapes[3] | shapes[4], (np.abs(x - 82) < 8) & (np.abs(y - 20) < 4)]
    height = np.where(np.any(masks, axis=0), 50.0, 0.0).astype(np.float32)
    for number, mask in enumerate(masks, start=1):
        label[mask] = number
        u, v = x[mask], y[mask]
        area.append(float(mask.sum()))
        middle.append([u.mean(), v.mean()])
        spread.append([u.var() + 1 / 12, np.mean((u - u.mean()) * (v - v.mean())), v.var() + 1 / 12])
    given = Segments(label, np.array(area), np.array(middle), np.array(spread), np.full(5, 50.0), np.zeros(5, bool))
    found = split_merged(given, height, np.ones(5, bool))
    assert len(found.area_px) == 6
    pair = found.middle_px[[3, 5]][np.argsort(found.middle_px[[3, 5], 0])]
    assert pair == pytest.approx(np.array([[52.0, 40.0], [61.0, 42.0]]), abs=0.6)
    assert found.area_px[[3, 5]] == pytest.approx(np.full(2, area[3] / 2))
    assert found.contrast[5] == 50.0
    assert found.middle_px[4] == pytest.approx(middle[4])
    own, other = (found.labels == number for number in (4, 6))
    assert np.hypot(*(np.array([x[own].mean(), y[own].mean()]) - found.middle_px[3])) < 1.5
    assert np.hypot(*(np.array([x[other].mean(), y[other].mean()]) - found.middle_px[5])) < 1.5
    assert split_merged(given, height, np.arange(5) != 3) is given
    cut = replace(given, at_border=np.arange(5) == 3)
    assert split_merged(cut, height, np.ones(5, bool)) is cut


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        (np.full((9, 9), 7, np.uint8), 7.0),
        (np.full((9, 9), 300, np.uint16), 300.0),
        (np.full((9, 9), 0.5), 127.5),
        (np.full((9, 9), 1.0), 255.0),
        (np.full((9, 9), 1.5), 1.5),
        (np.full((9, 9, 1), 7, np.uint8), 7.0),
        (np.ones((9, 9), bool), 1.0),
    ],
)
def test_grey_levels_are_those_of_whole_numbers(given: np.ndarray, wanted: float) -> None:
    assert to_grey(given, 1.0).tolist() == np.full((9, 9), wanted).tolist()


def test_colours_are_weighed_as_the_eye_does_and_transparency_is_left_out() -> None:
    for channel, weight in enumerate((0.114, 0.587, 0.299, 0.0)):
        image = np.zeros((8, 8, 4), np.uint8)
        image[..., channel] = 100
        assert to_grey(image, 1.0) == pytest.approx(np.full((8, 8), 100 * weight), abs=1e-4)
    with refused("image-too-small", 7, 9):
        to_grey(np.zeros((9, 7)), 1.0)
    assert to_grey(np.zeros((100, 100), np.uint8), 0.01).shape == (100, 100)
    with refused("image-too-large", 101, 100):
        to_grey(np.zeros((100, 101), np.uint8), 0.01)


def test_a_point_is_in_a_mask_by_its_nearest_pixel() -> None:
    mask = np.zeros((5, 7), bool)
    mask[2, 3] = True
    points = np.array([[3.0, 2.0], [3.49, 2.49], [3.51, 2.0], [2.0, 3.0], [-4.0, 2.0], [99.0, 99.0]])
    assert inside(mask, points).tolist() == [True, True, False, False, False, False]
    mask[4, 6] = True
    assert inside(mask, points)[-1]


def test_blobs_near_the_edge_of_a_masked_image_alone_are_cut() -> None:
    y, x = np.mgrid[:80, :120]
    image = np.full((80, 120), 200.0)
    for u, v in ((20, 20), (60, 20), (100, 20), (20, 60), (60, 60), (100, 76)):
        image -= 150.0 / (1 + np.exp(4 * (np.hypot(x - u, y - v) - 5)))
    mask = np.zeros((80, 120), bool)
    mask[8:, 10:112] = True
    blobs = Detector(DetectSpec(), True, 10.0, mask).find(image)
    assert blobs.positions_px == pytest.approx(
        np.array([[20, 20], [60, 20], [100, 20], [20, 60], [60, 60], [100, 76]]), abs=0.35
    )
    assert blobs.at_border.tolist() == [False] * 5 + [True]
    assert blobs.diameter_px[:5] == pytest.approx(np.full(5, 10.0), rel=0.05)
    assert blobs.contrast[:5] == pytest.approx(np.full(5, 150.0), rel=0.05)
    assert blobs.take(blobs.at_border).positions_px.shape == (1, 2)
    assert len(Detector(DetectSpec(), True, 10.0, np.roll(mask, 60, axis=1)).find(image)) < 6


def test_the_middle_one_of_three_in_a_row_is_a_midpoint() -> None:
    row = np.array([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [3.0, 40.0]])
    assert is_midpoint(row).tolist() == [False, True, False, False]
    for off, between in ((0.74, True), (0.76, False)):
        bent = np.array([[0.0, 0.0], [10.0, off], [20.0, 0.0]])
        assert is_midpoint(bent)[1] == between
    assert is_midpoint(row[:2]).tolist() == [False, False]
    random = np.mean([is_midpoint(np.random.default_rng(seed).uniform(size=(60, 2))).mean() for seed in range(60)])
    assert random == pytest.approx(AT_RANDOM, abs=0.02)


def printed(count: int = 36, noise: float = 1.0, spread: float = 0.0) -> Blobs:
    side = int(np.ceil(np.sqrt(count)))
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)[:count] * 10.0
    contrast = 20.0 * np.exp(spread * np.random.default_rng(5).normal(size=count))
    return Blobs(grid, np.full(count, 5.0), contrast, np.full(count, 0.02), np.zeros(count, bool), noise)


def test_a_field_looks_printed_if_it_is_distinct_in_order_and_not_cut() -> None:
    field = FieldCandidate(True, 5.0, 36, 1.0, 1.0, 0.97)
    assert is_printed(printed(), field)
    assert not is_printed(printed(7), field)
    assert is_printed(printed(noise=20.0 * 5.0 / 30.1), field)
    assert not is_printed(printed(noise=20.0 * 5.0 / 29.9), field)
    for share, good in ((9, True), (10, False)):
        cut = replace(printed(), at_border=np.arange(36) < share)
        assert is_printed(cut, field) == good
    assert not is_printed(printed(), replace(field, roundness=0.58))
    strewn = replace(printed(), positions_px=np.random.default_rng(4).uniform(0, 60, (36, 2)))
    assert is_printed(strewn, field), "alike, though not in order"
    uneven = replace(printed(spread=0.5), positions_px=strewn.positions_px)
    assert not is_printed(uneven, field)
    threads = replace(printed(), positions_px=printed().positions_px * [1.0, 9.0])
    assert not is_printed(threads, replace(field, roundness=0.9))


@pytest.mark.parametrize(("dark", "diameter"), [(True, 7.0), (False, 11.0), (True, 24.0)])
def test_polarity_and_size_of_a_drawn_field_are_found(dark: bool, diameter: float) -> None:
    step = 2.2 * diameter
    y, x = np.mgrid[: int(5 * step), : int(6 * step)]
    away = np.hypot((x + step / 2) % step - step / 2, (y + step / 2) % step - step / 2)
    dots = 1 / (1 + np.exp(3 * (away - diameter / 2)))
    image = np.where(True, 120 + (-80 if dark else 80) * dots, 0) + np.random.default_rng(6).normal(0, 1.5, x.shape)
    found = next(choose_fields(image.astype(np.float32), DetectSpec()))
    assert found.dark == dark
    assert found.diameter_px == pytest.approx(0.76 * diameter, rel=0.1), "half the height of the smoothed disc"
    of_known = next(choose_fields(image.astype(np.float32), DetectSpec(polarity="dark" if dark else "bright")))
    assert of_known == found
    assert list(choose_fields(np.full((60, 60), 100.0, np.float32), DetectSpec())) == []


def hexagon_layout() -> np.ndarray:
    rows = [[0.0, 0.0, 20.0]]
    for ring, count in ((1, 6), (2, 12)):
        angle = 2 * np.pi * np.arange(count) / count
        rows += [[4.0 * ring * np.cos(a), 4.0 * ring * np.sin(a), 20.0 - ring] for a in angle]
    return np.array(rows)


def project(points: np.ndarray) -> np.ndarray:
    return 300.0 * points[..., :2] / (48.0 + points[..., 2:]) + [170.0, 130.0]


def test_the_symmetries_of_a_pattern_move_markers_onto_markers() -> None:
    layout = hexagon_layout()
    mark = np.array([6.0, 1.0, 18.5])
    pattern = build_pattern(layout, project, mark)
    assert len(pattern.symmetries) == 12
    assert pattern.mirrored.tolist() == [False] * 6 + [True] * 6
    assert pattern.symmetries[0].tolist() == list(range(19))
    assert pattern.marks_px is not None
    for order, turn, mirror, seen in zip(
        pattern.symmetries, pattern.turns_deg, pattern.mirrored, pattern.marks_px, strict=True
    ):
        c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        motion = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.diag([1, -1 if mirror else 1, 1])
        assert (layout @ motion.T)[order] == pytest.approx(layout, abs=1e-9)
        assert seen == pytest.approx(project(motion @ mark))
    assert pattern.rings is not None
    apart = cdist(pattern.expected_px, pattern.expected_px) + np.diag(np.full(19, np.inf))
    assert pattern.spacing_px == pytest.approx(apart.min())
    away = np.vstack([layout, [[40.0, 0.0, 10.0]]])
    lone = build_pattern(away, project)
    assert (len(lone.symmetries), lone.rings, lone.marks_px) == (2, None, None)
    gap = np.sort(cdist(lone.expected_px, lone.expected_px)[-1])[1]
    nearest = np.sort(cdist(lone.expected_px, lone.expected_px), axis=1)[:, 1]
    assert lone.widest_gap == pytest.approx(gap / np.median(nearest))
    assert build_pattern(np.array([[0.0, 0.0, 5.0]]), project).widest_gap == 0.0


@pytest.mark.parametrize(
    ("angle", "wrapped"), [(0, 0), (179.5, 179.5), (180, -180), (190, -170), (-190, 170), (725, 5)]
)
def test_angles_are_wrapped_to_a_half_turn_either_way(angle: float, wrapped: float) -> None:
    assert wrap_deg(float(angle)) == pytest.approx(wrapped)


@pytest.mark.parametrize("turn_deg", [0.0, 23.0, -130.0])
@pytest.mark.parametrize("mirror", [False, True])
def test_a_turned_or_mirrored_pattern_is_named_by_its_mark(turn_deg: float, mirror: bool) -> None:
    layout, mark = hexagon_layout(), np.array([6.0, 1.0, 18.5])
    pattern = build_pattern(layout, project, mark)
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    middle = np.array([170.0, 130.0])

    def show(pixels: np.ndarray) -> np.ndarray:
        return ((pixels - middle) * [1, -1 if mirror else 1]) @ np.array([[c, s], [-s, c]]) + middle

    order = np.random.default_rng(3).permutation(20)
    dots = show(np.vstack([pattern.expected_px, project(mark)[None]]))[order]
    found = assign_markers(dots, pattern)
    assert found.blob.tolist() == np.argsort(order)[:19].tolist()
    assert (found.mirrored, found.ambiguous) == (mirror, False)
    assert found.mark == int(np.argsort(order)[19])
    assert wrap_deg(found.turn_deg - turn_deg) == pytest.approx(0.0, abs=0.5)
    plain = assign_markers(show(pattern.expected_px)[order[order < 19]], pattern)
    assert len(plain.alternatives) == 11
    assert plain.mark == -1
    angles = [abs(each.turn_deg) for each in (plain, *plain.alternatives) if not each.mirrored]
    assert abs(plain.turn_deg) == min(angles)
    assert min(angles) <= 30.5


def test_markers_that_want_one_blob_share_the_blobs_with_the_least_squares() -> None:
    predicted, blobs = RNG.uniform(0, 50, (12, 2)), RNG.uniform(0, 50, (9, 2))
    reach = np.linspace(5, 20, 12)
    square = cdist(predicted, blobs) ** 2
    first = np.where(np.sqrt(square.min(axis=1)) < reach, square.argmin(axis=1), -1)
    found = _assign(predicted, blobs, reach, first)
    limited = np.minimum(square, reach[:, None] ** 2)
    rows, columns = linear_sum_assignment(limited)
    wanted = np.full(12, -1)
    for row, column in zip(rows, columns, strict=True):
        if square[row, column] < reach[row] ** 2:
            wanted[row] = column
    assert found.tolist() == wanted.tolist()
    used = found[found >= 0]
    assert len(set(used.tolist())) == len(used)
    alone = np.where(np.arange(12) == 3, first, -1)
    assert _assign(predicted, blobs, reach, alone).tolist() == alone.tolist()


def test_limits_of_a_printed_field_are_met_exactly_or_not() -> None:
    field = FieldCandidate(True, 5.0, 36, 1.0, 1.0, 0.97)
    exact = replace(printed(), contrast=np.full(36, 30.0), noise=5.0)
    assert not is_printed(exact, field), "it must be exceeded"
    assert is_printed(replace(exact, noise=4.999), field)
    assert is_printed(printed(), replace(field, roundness=0.59))
    assert is_printed(printed(9), field)
    strewn = np.random.default_rng(4).uniform(0, 60, (8, 2))
    assert is_printed(replace(printed(8), positions_px=strewn), field), "eight alike ones"
    assert not is_printed(replace(printed(7), positions_px=strewn[:7]), field)
    assert not is_printed(replace(printed(8), positions_px=strewn), replace(field, roundness=0.75))
