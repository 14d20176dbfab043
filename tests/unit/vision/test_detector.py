from pathlib import Path

import cv2
import numpy as np
import pytest
from drawn_dots import bound, draw_dots, lattice, match, with_noise

from errors import refused
from palpate.core import generator
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.vision import Detector, DetectSpec, prepare_detector
from palpate.vision.choose_field import is_midpoint

SETTINGS = [(50.0, 5.0), (100.0, 3.0), (100.0, 1.0), (200.0, 2.0)]


def drawn(diameter, edge, contrast, noise, count=12):
    rng = generator(3, diameter, edge, contrast, noise)
    centres, shape = lattice(count, 2 * diameter + 6, rng)
    return with_noise(draw_dots(centres, diameter, edge, contrast, shape), noise, rng), centres


@pytest.mark.parametrize("diameter", [4.0, 6.0, 8.0, 12.0])
@pytest.mark.parametrize("edge", [0.6, 1.0, 1.5])
def test_centres_reach_the_bound_and_every_dot_is_found_once(diameter, edge):
    for contrast, noise in SETTINGS:
        image, centres = drawn(diameter, edge, contrast, noise)
        errors, missed, extra = match(prepare_detector(image).find(image).positions_px, centres)
        rms = np.sqrt(np.mean(errors**2))
        assert rms <= 1.3 * bound(diameter, edge, contrast, noise) + 0.01, (contrast, noise, rms)
        if contrast / noise >= 15:
            assert (missed, extra) == (0, 0)


@pytest.mark.parametrize("diameter", [4.0, 6.0, 12.0])
def test_centres_have_no_bias_over_the_phases_of_a_pixel(diameter):
    phase = np.arange(9) / 9 - 4 / 9
    spacing = 2 * diameter + 6
    centres = np.array(
        [[(i + 0.5) * spacing + phase[i], (j + 0.5) * spacing + phase[j]] for i in range(9) for j in range(9)]
    )
    image = draw_dots(centres, diameter, 1.0, 100.0, (int(9 * spacing) + 2,) * 2)
    errors, missed, extra = match(prepare_detector(image).find(image).positions_px, centres)
    assert (missed, extra) == (0, 0)
    assert np.abs(errors).max() <= 0.01
    assert np.abs(errors.mean(axis=0)).max() <= 1e-3


def test_the_standard_deviation_it_states_is_the_one_it_has():
    image, centres = drawn(6.0, 1.0, 100.0, 3.0, count=20)
    blobs = prepare_detector(image).find(image)
    errors, _, _ = match(blobs.positions_px, centres)
    assert np.median(blobs.sigma_px) == pytest.approx(np.sqrt(np.mean(errors**2)), rel=0.15)
    assert blobs.noise == pytest.approx(3.0, rel=0.1)


@pytest.mark.parametrize("kind", ["bright", "colour", "sixteen bit", "single precision"])
def test_polarity_colour_and_depth_of_the_image_change_nothing(kind):
    image, centres = drawn(7.0, 1.0, 100.0, 2.0)
    reference = prepare_detector(image).find(image)
    other = {
        "bright": 255 - image,
        "colour": np.stack([image] * 3, axis=-1),
        "sixteen bit": image.astype(np.uint16) * 200,
        "single precision": image.astype(np.float32) * 40.0,
    }[kind]
    detector = prepare_detector(other)
    assert detector.dark == (kind != "bright")
    np.testing.assert_allclose(detector.find(other).positions_px, reference.positions_px, atol=1e-3)
    _, missed, extra = match(reference.positions_px, centres)
    assert (missed, extra) == (0, 0)


@pytest.mark.parametrize("diameter", [5.0, 9.0, 20.0, 45.0])
def test_the_size_of_the_dots_is_read_from_the_image(diameter):
    image, centres = drawn(diameter, 1.0, 80.0, 2.0, count=7)
    detector = prepare_detector(image)
    assert detector.diameter_px == pytest.approx(diameter, rel=0.15)
    blobs = detector.find(image)
    assert len(blobs) == len(centres)
    np.testing.assert_allclose(blobs.diameter_px, diameter, rtol=0.1)


def test_opencv_finds_the_same_dots():
    image, centres = drawn(8.0, 1.0, 100.0, 2.0)
    detector = prepare_detector(image, DetectSpec(method="opencv"))
    errors, missed, extra = match(detector.find(image).positions_px, centres)
    assert (missed, extra) == (0, 0)
    assert np.sqrt(np.mean(errors**2)) < 0.1


def test_uneven_light_and_clutter_outside_the_field_do_not_matter():
    rng = generator(5, "clutter")
    layout = place_markers(build_skin(DomeSpec()), MarkerSpec(count=91))
    centres = layout.positions[:, :2] * 5.0 + [173.0, 130.0]
    image = draw_dots(centres, 7.0, 1.0, 110.0, (260, 346), ground=200.0)
    y, x = np.mgrid[:260, :346]
    image *= 1.0 - 0.5 * ((x - 150) ** 2 + (y - 100) ** 2) / 230**2
    image[:, :12], image[240:, 320:] = 30.0, 250.0
    image[5:12, 300:306] = 20.0
    image = with_noise(image, 2.0, rng)
    errors, missed, extra = match(prepare_detector(image).find(image).positions_px, centres)
    assert (missed, extra) == (0, 0)
    assert np.sqrt(np.mean(errors**2)) < 0.05


def test_dots_that_nearly_touch_are_two_and_a_cut_one_is_marked():
    centres = np.array([[40.0, 40], [50, 40], [80, 40], [110, 40], [40, 80], [80, 80], [110, 80], [0.5, 60]])
    image = with_noise(draw_dots(centres, 8.0, 0.8, 120.0, (110, 140)), 2.0, generator(1, "touch"))
    blobs = prepare_detector(image, DetectSpec(mask="none")).find(image)
    assert len(blobs) == len(centres)
    assert blobs.positions_px[blobs.at_border].round().tolist() == [[0.0, 60.0]] or blobs.at_border.sum() == 1


def test_elongated_dots_keep_their_centre():
    rng = generator(2, "ellipse")
    centres, shape = lattice(8, 30, rng)
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    image = np.full(shape, 200.0)
    for column, row in centres:
        a, b = (x - column) + 0.6 * (y - row), (y - row) - 0.6 * (x - column)
        image -= 100.0 / (1.0 + np.exp((np.hypot(a / 7.0, b / 4.0) - 1.0) * 5.0))
    errors, missed, extra = match(prepare_detector(image).find(image).positions_px, centres)
    assert (missed, extra) == (0, 0)
    assert np.abs(errors).max() < 0.01


@pytest.mark.parametrize("image", [np.zeros((260, 346), np.uint8), np.full((50, 60, 3), 255, np.uint8)])
def test_an_even_image_has_no_field_of_dots(image):
    with refused("markers-not-found"):
        prepare_detector(image)
    assert len(Detector(DetectSpec(), True, 6.0, None).find(image)) == 0


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((1, 1), np.uint8), ("image-too-small", "1")),
        (np.lib.stride_tricks.as_strided(np.zeros(1, np.uint8), (20_000, 20_000), (0, 0)), ("image-too-large", "40")),
        (np.zeros((10, 10, 7)), ("image-shape-wrong",)),
        (np.zeros(5), ("image-shape-wrong",)),
        (np.full((20, 20), np.nan), ("image-not-finite",)),
        (np.array([["a"]]), ("image-shape-wrong",)),
    ],
)
def test_what_is_no_usable_image_is_refused(image, words):
    with refused(*words):
        prepare_detector(image)


def test_an_image_of_another_size_than_the_first_is_refused():
    image, _ = drawn(6.0, 1.0, 100.0, 2.0)
    with refused("image-size-changed"):
        prepare_detector(image).find(image[:100])


def pairs_and_single_dots(apart, diameter, edge, rng, blurred=False):
    """A lattice of which every third dot is a pair, `apart` its diameter; overlapping ink does not add up."""
    count, pitch = 6, 3 * diameter + 8
    grid, shape = lattice(count, pitch, rng)
    turn = rng.uniform(0, 2 * np.pi, len(grid))
    half = apart * diameter / 2 * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    paired = np.arange(len(grid)) % 3 == 0
    centres = np.vstack([grid[~paired], grid[paired] - half[paired], grid[paired] + half[paired]])
    if blurred:
        return draw_dots(centres, diameter, edge, 100.0, shape), centres, int((~paired).sum())
    single = [draw_dots(centres[None, k], diameter, edge, 100.0, shape) for k in range(len(centres))]
    return np.min(single, axis=0), centres, int((~paired).sum())


@pytest.mark.parametrize("diameter", [6.0, 8.0, 12.0])
@pytest.mark.parametrize("apart", [0.9, 1.0, 1.15])
def test_dots_that_touch_or_overlap_are_parted_and_keep_their_centres(diameter, apart):
    for edge in (0.6, 1.0, 1.5):
        rng = generator(6, "pairs", diameter, apart, edge)
        image, centres, alone = pairs_and_single_dots(apart, diameter, edge, rng)
        found = prepare_detector(with_noise(image, 2.0, rng)).find(with_noise(image, 2.0, rng)).positions_px
        errors, missed, extra = match(found, centres)
        assert (missed, extra) == (0, 0)
        of_pairs = np.linalg.norm(found[:, None] - centres[None], axis=-1).argmin(axis=1) >= alone
        assert np.sqrt(np.mean(errors[of_pairs] ** 2)) < 0.05
        assert np.sqrt(np.mean(errors[~of_pairs] ** 2)) < 0.025


def test_dots_that_blur_into_each_other_are_parted():
    rng = generator(6, "blurred pairs")
    image, centres, _ = pairs_and_single_dots(1.1, 8.0, 2.0, rng, blurred=True)
    errors, missed, extra = match(prepare_detector(image).find(with_noise(image, 2.0, rng)).positions_px, centres)
    assert (missed, extra) == (0, 0)
    assert np.sqrt(np.mean(errors**2)) < 0.2  # each holds some of the other's blur


@pytest.mark.parametrize("elongation", [1.5, 2.0, 2.4])
def test_long_single_dots_are_not_parted(elongation):
    rng = generator(2, "long", elongation)
    centres, shape = lattice(8, 34, rng)
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    image = np.full(shape, 200.0)
    for number, (column, row) in enumerate(centres):
        long, short = (elongation * 5.0, 5.0) if number % 3 == 0 else (5.0, 5.0)
        a, b = 0.8 * (x - column) + 0.6 * (y - row), 0.8 * (y - row) - 0.6 * (x - column)
        image -= 100.0 / (1.0 + np.exp((np.hypot(a / long, b / short) - 1.0) * 6.0))
    errors, missed, extra = match(prepare_detector(image).find(with_noise(image, 2.0, rng)).positions_px, centres)
    assert extra == 0
    assert missed == 0
    assert np.abs(errors).max() < 0.1


def before_clutter(seed):
    """A video's image: 7 × 5 black dots of 8 px before a room of large bright and dark things, and where they are."""
    rng = generator(9, "room", seed)
    grid = np.stack(np.meshgrid(np.arange(7), np.arange(5)), axis=-1).reshape(-1, 2)
    centres = grid * [46.0, 50.0] + [22.0, 20.0] + rng.uniform(-1.5, 1.5, (35, 2))
    y, x = np.mgrid[:240, :320]
    image = np.full((240, 320), 150.0)
    for _ in range(60):
        column, row, size = rng.uniform(0, 320), rng.uniform(0, 240), rng.uniform(6, 40)
        inside = np.hypot((x - column) / size, (y - row) / (size * rng.uniform(0.4, 1))) < 1
        image[inside] = rng.uniform(60, 240)
    dots = draw_dots(centres, 8.0, 0.8, 1.0, (240, 320), ground=1.0)  # 0 in a dot, 1 outside
    return with_noise(20.0 + (image - 20.0) * dots, 1.5, rng), centres


@pytest.mark.parametrize("seed", range(5))
def test_dots_before_a_cluttered_room_are_recognised_by_their_order(seed):
    image, centres = before_clutter(seed)
    detector = prepare_detector(image)
    assert detector.dark
    assert detector.diameter_px == pytest.approx(8.0, rel=0.2)
    _, missed, _ = match(detector.find(image).positions_px, centres)
    assert missed <= 6  # those that lie on the edge of something dark


@pytest.mark.parametrize("bright", [False, True], ids=["dark", "bright"])
@pytest.mark.parametrize("tilted", [False, True], ids=["even", "uneven"])
def test_a_small_field_before_a_dark_room_with_a_rim_is_found(bright, tilted):
    """37 markers in rings; the skin between them looks like light blobs, and stray blobs dilute their order."""
    centres = np.array([(160.0, 120.0)] + [ring_point(k, j) for k in (1, 2, 3) for j in range(6 * k)])
    y, x = np.mgrid[:240, :320].astype(float)
    light = 1.0 - (0.35 * (x + y) / 560.0 if tilted else 0.0)
    image = np.full((240, 320), 16.0)
    skin, dot = (70.0, 120.0) if bright else (130.0, 60.0)
    image[np.hypot(x - 160, y - 120) < 94] = 110.0  # the rim
    image[np.hypot(x - 160, y - 120) < 90] = skin
    for column, row in centres:
        image[np.hypot(x - column, y - row) < 3.2] = dot
    for column, row, radius, level in ((30, 40, 7, 90), (290, 60, 5, 70), (280, 200, 3, 60), (40, 210, 8, 100)):
        image[np.hypot(x - column, y - row) < radius] = level
    noise = generator(5, "rim").normal(0, 1.0, image.shape)
    image = np.clip(cv2.GaussianBlur(image * light, (0, 0), 0.9) + noise, 0, 255).astype(np.uint8)
    detector = prepare_detector(image)
    assert detector.dark is not bright
    assert detector.diameter_px == pytest.approx(6.4, rel=0.15)
    _, missed, _ = match(detector.find(image).positions_px, centres)
    assert missed == 0


def ring_point(ring, number):
    """Centre (px) of a marker of a ring of six times its number."""
    angle = 2.0 * np.pi * number / (6 * ring)
    return 160.0 + 26.0 * ring * np.cos(angle), 120.0 + 26.0 * ring * np.sin(angle)


def test_texture_without_dots_is_no_field():
    rng = generator(2, "texture")
    with refused("markers-not-found"):
        prepare_detector(rng.integers(120, 136, (240, 320), dtype=np.uint8))


def test_which_dots_lie_half_way_between_two_others():
    points = np.array([[0.0, 0], [10, 0], [20, 0.5], [30, 0], [50, 60], [70, 20]])
    assert is_midpoint(points).tolist() == [False, True, True, False, False, False]
    assert not is_midpoint(points[:2]).any()


@pytest.mark.parametrize(
    "process",
    [
        lambda image: cv2.blur(image, (3, 3)),
        lambda image: cv2.GaussianBlur(image, (0, 0), 0.8),
        lambda image: cv2.medianBlur(image, 3),
        *(
            lambda image, quality=quality: cv2.imdecode(cv2.imencode(".jpg", image, [1, quality])[1], 0)
            for quality in (95, 80, 60, 40)
        ),
    ],
    ids=["box", "Gauss", "median", "JPEG 95", "JPEG 80", "JPEG 60", "JPEG 40"],
)
def test_markers_of_a_smoothed_or_compressed_image_are_found(process):
    image = cv2.imread(str(Path(__file__).parents[3] / "examples" / "data" / "rest.png"), 0)
    expected = prepare_detector(image).find(image).positions_px
    assert len(expected) == 61
    changed = process(image)
    errors, missed, extra = match(prepare_detector(changed).find(changed).positions_px, expected)
    assert (missed, extra) == (0, 0)
    assert np.sqrt(np.mean(errors**2)) < 0.1


@pytest.mark.parametrize("contrast", [0.1, 0.2, 0.3])
@pytest.mark.parametrize("lamps", [4, 8, 12])
def test_faint_markers_beside_a_few_lamps_are_found(contrast, lamps):
    image = cv2.imread(str(Path(__file__).parents[3] / "examples" / "data" / "rest.png"), 0)
    expected = prepare_detector(image).find(image).positions_px
    middle = float(np.median(image))
    faint = middle - contrast * (image.astype(float) - middle)
    angle = 2 * np.pi * np.arange(lamps) / lamps
    for x, y in np.array(image.shape[::-1]) / 2 + 122 * np.column_stack([np.cos(angle), np.sin(angle)]):
        cv2.circle(faint, (int(x), int(y)), 5, 255.0, -1)
    changed = np.rint(np.clip(faint, 0, 255)).astype(np.uint8)
    _, missed, extra = match(prepare_detector(changed).find(changed).positions_px, expected)
    assert missed == 0
    assert extra <= lamps
