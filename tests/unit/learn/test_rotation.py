"""Turned presses: fields, the sense in which tilts turn with them, and what they teach."""

from dataclasses import replace

import numpy as np
import pytest

from drawn_tactip import DrawnSensor, draw_motions, place_heads
from needs import needs
from palpate.learn.member import MarkerNetwork, TrainingRun
from palpate.learn.rotation import (
    COUNT,
    RotationAugmentation,
    RotationOperators,
    find_rotation_sense,
    pattern_order,
    rotation,
)
from palpate.learn.training_set import TrainingSet

SENSOR = DrawnSensor(rings=5)
STILL = np.zeros((4, 2))


def drawn(count: int, seed: int, shear: float = 3.0, tilt: float = 18.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Dots at rest (m, 2), displacements (n, m, 2) and poses (n, 3), without an image between."""
    motions = draw_motions(count, seed, shear, tilt)
    rest = place_heads(SENSOR, np.zeros(6), STILL)[0]
    return rest, np.array([place_heads(SENSOR, one, STILL)[0] for one in motions]) - rest, motions[:, :3]


@pytest.mark.parametrize("steps", [1, 7, 18, 35])
@pytest.mark.parametrize("pattern", ["hexagon", "square", "random"])
def test_a_turned_field_is_the_field_of_the_turned_place(steps, pattern):
    rest = DrawnSensor(rings=7, pattern=pattern).pins() * 10.0
    turns = RotationOperators(rest)

    def field(places):
        x, y = (places - turns.middle).T / 100.0
        return np.c_[np.sin(1.3 * x + 0.4 * y) + 0.3 * y, x * y - np.cos(0.8 * y)]

    turn = rotation(steps)
    asked = (rest - turns.middle) @ turn + turns.middle
    expected = field(asked) @ turn.T
    found = (turns.operator(steps) @ field(rest).reshape(-1)).reshape(-1, 2)
    inner = np.linalg.norm(rest - turns.middle, axis=1) < 0.75 * np.linalg.norm(rest - turns.middle, axis=1).max()
    assert np.abs(found - expected)[inner].max() < 0.03
    assert np.sqrt(np.mean((found - expected) ** 2)) < 0.1


def test_a_whole_turn_changes_nothing():
    turns = RotationOperators(SENSOR.pins())
    assert np.array_equal(turns.operator(COUNT), np.eye(2 * len(SENSOR.pins())))


def test_the_recording_tells_in_which_sense_tilts_turn():
    rest, moved, poses = drawn(80, 1)
    tilt = poses[:, :2]
    assert find_rotation_sense(rest, moved, tilt) == -find_rotation_sense(rest, moved, tilt * [1, -1]) != 0
    assert (
        find_rotation_sense(rest, moved[..., ::-1], tilt) == 0
        or find_rotation_sense(rest[:, ::-1], moved[..., ::-1], tilt) == -1
    )
    shuffled = np.random.default_rng(0).permutation(tilt)
    assert find_rotation_sense(rest, moved, shuffled) == 0


def train_rotated(samples):
    from palpate.learn.train_member import train_marker_network

    return MarkerNetwork("turned", train_marker_network("turned", samples, epochs=120))


def test_turned_presses_teach_what_many_would_and_turned_the_wrong_way_they_do_not():
    needs("torch")
    rest, moved, poses = drawn(400, 2)
    rng = np.random.default_rng(3)
    moved = moved + rng.normal(0.0, 0.3, moved.shape)
    number = np.arange(400)
    lesson = TrainingSet(moved, poses, number < 80, (number >= 80) & (number < 160), 0)
    sense = find_rotation_sense(rest, moved[:80], poses[:80, :2])

    def error(part):
        return float(np.sqrt(np.mean((part.predict(moved[160:]) - poses[160:])[:, :2] ** 2)))

    plain = error(MarkerNetwork.train("plain", lesson, TrainingRun()))
    turned, wrong = (
        error(train_rotated(replace(lesson, rotation=RotationAugmentation(rest, 0.0 * rest, one))))
        for one in (sense, -sense)
    )
    assert turned < 0.75 * plain
    assert wrong > 1.3 * turned


@pytest.mark.parametrize(("pattern", "order"), [("hexagon", 6), ("square", 4), ("random", 1)])
def test_a_pattern_tells_its_own_symmetry(pattern, order):
    rest = DrawnSensor(rings=7, pattern=pattern).pins() * 10.0
    assert pattern_order(rest) == order


def test_pictures_turn_as_their_dots_do():
    needs("torch")
    cv2 = needs("cv2")
    from palpate.learn.train_member import rotate_images

    picture, middle = np.zeros((64, 64), np.uint8), np.array([30.0, 33.0])
    cv2.circle(picture, (44, 33), 2, 255, -1)
    for number in range(6):
        turned = rotate_images(picture[None], middle, 6, number)[0, 0].numpy().astype(float)
        rows, columns = np.mgrid[:64, :64]
        found = np.array([(columns * turned).sum(), (rows * turned).sum()]) / turned.sum()
        expected = middle + rotation(6 * number) @ [14.0, 0.0]
        assert np.abs(found - expected).max() < 0.3


@pytest.mark.slow
def test_a_layout_that_leans_is_told_from_the_mean():
    """The layout of a pressed image, which no turn leaves as it is, and displacements from it."""
    needs("torch")
    rest, moved, poses = drawn(300, 4)
    lean = moved[np.argmax(np.hypot(*poses[:, :2].T))]
    base, number = (moved - lean).mean(axis=0), np.arange(300)
    lesson = TrainingSet(moved - lean, poses, number < 80, (number >= 80) & (number < 140), 0)
    places = rest + lean + base
    assert pattern_order(places) == 6 > pattern_order(rest + lean)
    turning = RotationAugmentation(
        places, base, find_rotation_sense(places, moved[:80] - lean - base, poses[:80, :2])
    )
    part = train_rotated(replace(lesson, rotation=turning))
    plain = MarkerNetwork.train("plain", lesson, TrainingRun())

    def error(one):
        return float(np.sqrt(np.mean((one.predict(lesson.inputs[140:]) - poses[140:])[:, :2] ** 2)))

    assert error(part) < 0.75 * error(plain)
