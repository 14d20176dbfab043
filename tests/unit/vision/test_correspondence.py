"""Dots of unknown layouts get numbers that last, and get them again in images far apart, or it is said that not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drawn_gel import DrawnGel, place_pins
from drawn_tactip import DrawnSensor, another_unit, draw_image, draw_motions, place_heads
from errors import refused
from palpate.core.run import Progress
from palpate.vision import (
    MarkerMatcher,
    MatchFault,
    assign_images,
    choose_reference,
    number_markers,
    prepare_detector,
)

STILL = np.zeros((4, 2))
SHAPE = (420, 420)


def heads_of(sensor: DrawnSensor, count: int, seed: int = 0, **motion: float) -> tuple[np.ndarray, np.ndarray]:
    rest = place_heads(sensor, np.zeros(6), STILL)[0]
    return rest, np.array([place_heads(sensor, one, STILL)[0] for one in draw_motions(count, seed, **motion)])


def share_right(sensor: DrawnSensor, count: int, noise: float = 0.1, **motion: float) -> tuple[float, int, int]:
    """Share of dots with their own number, images that are believed, and images that are believed and wrong."""
    rest, heads = heads_of(sensor, count, **motion)
    rng = np.random.default_rng(0)
    layout = number_markers(rest)
    own = np.argmin(np.linalg.norm(layout.rest_px[:, None] - rest[None], axis=-1), axis=1)
    correspondent, right, good, wrong = MarkerMatcher(layout, SHAPE), [], 0, 0
    for places in heads:
        dots = rng.permutation(places + rng.normal(0, noise, places.shape))
        found = correspondent.find(dots)
        correspondent.remember(dots, found)
        off = np.linalg.norm(layout.rest_px + found.moved_px - places[own], axis=1)
        right.append(((off < 3) & found.found).mean())
        good += found.accepted
        wrong += found.accepted and right[-1] < 0.9
    return float(np.mean(right)), good, wrong


@pytest.mark.parametrize(
    "sensor",
    [
        DrawnSensor(),
        DrawnSensor(rings=6),
        DrawnSensor(rings=9, pattern="square"),
        DrawnSensor(rings=7, pattern="rings"),
        DrawnSensor(rings=7, pattern="random"),
    ],
    ids=["331 in a hexagon", "127 in a hexagon", "a square", "rings", "at random"],
)
def test_dots_sheared_by_several_spacings_keep_their_numbers(sensor: DrawnSensor) -> None:
    right, good, wrong = share_right(sensor, 40)
    assert right > 0.98
    assert good >= 38
    assert wrong == 0


def test_dots_moved_by_less_than_two_fifths_of_a_spacing_are_found_at_once() -> None:
    right, good, _ = share_right(DrawnSensor(rings=6), 30, shear=0.5, tilt=3.0)
    assert right > 0.999
    assert good == 30


def test_numbers_do_not_depend_on_the_order_in_which_dots_come() -> None:
    rest, _ = heads_of(DrawnSensor(), 1)
    mixed = np.random.default_rng(1).permutation(rest)
    np.testing.assert_array_equal(number_markers(rest).rest_px, number_markers(mixed).rest_px)


def test_white_on_black_and_black_on_white_are_told_apart_by_the_image() -> None:
    places, radii = place_heads(DrawnSensor(rings=6), np.zeros(6), STILL)
    for dark in (False, True):
        image = draw_image(places, radii, np.random.default_rng(0), dark=dark)
        detector = prepare_detector(image)
        assert detector.dark is dark
        assert len(detector.find(image)) == len(places)


def test_dots_that_left_the_image_are_missing_and_the_others_stay_numbered() -> None:
    rest, heads = heads_of(DrawnSensor(), 12)
    layout = number_markers(rest)
    own = np.argmin(np.linalg.norm(layout.rest_px[:, None] - rest[None], axis=-1), axis=1)
    correspondent = MarkerMatcher(layout, SHAPE)
    for places in heads:
        seen = places[:, 0] < np.quantile(places[:, 0], 0.93)
        found = correspondent.find(places[seen])
        if found.accepted:
            assert found.found[~seen[own]].sum() <= 3
            off = np.linalg.norm(layout.rest_px + found.moved_px - places[own], axis=1)
            assert (off[found.found] < 3).mean() > 0.97


def test_dots_strewn_at_random_are_not_believed() -> None:
    rest, _ = heads_of(DrawnSensor(rings=6), 1)
    correspondent = MarkerMatcher(number_markers(rest), SHAPE)
    strewn = np.random.default_rng(0).uniform(30, 390, (127, 2))
    assert not correspondent.find(strewn).accepted


def test_an_image_with_hardly_a_dot_is_said_to_have_none() -> None:
    rest, _ = heads_of(DrawnSensor(rings=6), 1)
    assert MarkerMatcher(number_markers(rest), SHAPE).find(rest[:20]).fault is MatchFault.NO_DOTS


def test_nearest_places_alone_lose_most_dots_of_a_sheared_sensor() -> None:
    rest, heads = heads_of(DrawnSensor(), 20)
    layout = number_markers(rest)
    own = np.argmin(np.linalg.norm(layout.rest_px[:, None] - rest[None], axis=-1), axis=1)
    naive = MarkerMatcher(layout, SHAPE, smooth=False)
    off = [np.linalg.norm(layout.rest_px + naive.find(h).moved_px - h[own], axis=1) for h in heads]
    assert np.mean(np.array(off) < 3) < 0.7


def test_the_dots_of_another_unit_of_the_make_are_found_by_the_layout_of_the_first() -> None:
    sensor = DrawnSensor()
    rest, _ = heads_of(sensor, 1)
    other, _ = heads_of(replace(another_unit(sensor), seed=3), 1)
    found = MarkerMatcher(number_markers(rest), SHAPE).find(other)
    assert found.accepted
    assert found.found.mean() > 0.97


@pytest.mark.slow
def test_where_the_skin_has_a_kink_the_motions_of_the_sensor_are_learnt_and_most_of_it_is_found() -> None:
    sensor, rng = DrawnGel(), np.random.default_rng(0)
    rest = place_pins(sensor, np.zeros(6), STILL)[0]
    drawn = [place_pins(sensor, one, STILL) for one in draw_motions(90, 2, shear=2.5, tilt=15.0)]
    dots = []
    for places, look in drawn:  # heads that touch are one dot between both, and a few are lost
        apart = np.linalg.norm(places[:, None] - places[None], axis=-1) + 1e9 * np.eye(len(places))
        fused = apart.min(axis=1) < 1.6 * look[:, 0]
        alone = places[~fused & (rng.random(len(places)) > 0.02)]
        dots.append(np.vstack([alone, 0.5 * (places + places[apart.argmin(axis=1)])[fused][::2]]))
    count = len(dots)
    found = assign_images((*dots, rest), count, SHAPE, True, Progress())
    own = np.argmin(np.linalg.norm(found.layout.rest_px[:, None] - rest[None], axis=-1), axis=1)
    off = [np.linalg.norm(found.layout.rest_px + found.moved_px[k] - drawn[k][0][own], axis=1) for k in range(count)]
    wrong = (np.array(off) > 8) & found.found[:count]
    good = found.good[:count]
    assert good.mean() > 0.4  # fewer than one in ten by smooth fields alone
    assert wrong[good].mean() < 0.02
    assert len(found.motion) > 10


def test_where_the_skin_is_smooth_nothing_is_learnt_and_none_is_wrong() -> None:
    """Motions learnt from 300 images had 40 of 4 000 others believed and wrong, where smooth fields have none."""
    sensor, rng = DrawnSensor(), np.random.default_rng(0)
    rest, heads = heads_of(sensor, 60)
    dots = [rng.permutation(places + rng.normal(0, 0.1, places.shape)) for places in heads]
    count = len(dots)
    found = assign_images((*dots, rest), count, SHAPE, True, Progress())
    assert not len(found.motion)
    assert found.good[:count].all()
    own = np.argmin(np.linalg.norm(found.layout.rest_px[:, None] - rest[None], axis=-1), axis=1)
    off = np.linalg.norm(found.layout.rest_px + found.moved_px[:count] - heads[:, own], axis=-1)
    assert (off[found.found[:count]] < 2).all()


def test_too_few_dots_at_rest_are_refused(tmp_path: Path) -> None:
    with refused("rest-markers-few", "3"):
        number_markers(np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]]))


def test_images_with_hardly_a_blob_give_no_layout() -> None:
    with refused("markers-few", "picture"):
        choose_reference([np.ones((2, 2)), np.ones((3, 2)), np.ones((40, 2))], 3)
