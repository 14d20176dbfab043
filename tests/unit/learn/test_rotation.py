"""Turned presses: fields, the sense in which tilts turn with them, and what they teach."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drawn_tactip import DrawnSensor, draw_motions, place_heads
from needs import needs
from palpate.learn.gaussian_process import choose_symmetry
from palpate.learn.member import MarkerNetwork
from palpate.learn.rotation import (
    ANGLES,
    RotationAugmentation,
    RotationOperators,
    find_frame,
    find_rotation,
    pattern_order,
    rotation,
    tilt_angles,
    tilt_vector,
)
from palpate.learn.training_set import TrainingSet

SENSOR = DrawnSensor(rings=5)
STILL = np.zeros((4, 2))
EPOCHS = 80
"""Enough for the differences between trainings that are compared here."""


def drawn(count: int, seed: int, shear: float = 3.0, tilt: float = 18.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Dots at rest (m, 2), displacements (n, m, 2) and poses (n, 3), without an image between."""
    motions = draw_motions(count, seed, shear, tilt)
    rest = place_heads(SENSOR, np.zeros(6), STILL)[0]
    return rest, np.array([place_heads(SENSOR, one, STILL)[0] for one in motions]) - rest, motions[:, :3]


@pytest.mark.parametrize("turn", [rotation(1), rotation(18), rotation(35), rotation(7) @ np.diag([1.0, -1.0])])
@pytest.mark.parametrize("pattern", ["hexagon", "square", "random"])
def test_a_turned_field_is_the_field_of_the_turned_place(turn, pattern):
    rest = DrawnSensor(rings=7, pattern=pattern).pins() * 10.0
    turns = RotationOperators(rest)

    def field(places):
        x, y = (places - turns.middle).T / 100.0
        return np.c_[np.sin(1.3 * x + 0.4 * y) + 0.3 * y, x * y - np.cos(0.8 * y)]

    asked = (rest - turns.middle) @ turn + turns.middle
    expected = field(asked) @ turn.T
    found = (turns.operator(turn) @ field(rest).reshape(-1)).reshape(-1, 2)
    inner = np.linalg.norm(rest - turns.middle, axis=1) < 0.75 * np.linalg.norm(rest - turns.middle, axis=1).max()
    assert np.abs(found - expected)[inner].max() < 0.03
    assert np.sqrt(np.mean((found - expected) ** 2)) < 0.1


@pytest.mark.parametrize("angles", ANGLES)
def test_tilts_are_those_of_the_rotation(angles):
    tilt = np.random.default_rng(0).uniform(-25, 25, (40, 2))
    x, y = (Rotation.from_euler(axis, tilt[:, [k]], degrees=True) for k, axis in enumerate("xy"))
    whole = {"vector": Rotation.from_rotvec(np.c_[tilt, np.zeros(40)], degrees=True), "ry-rx": y * x, "rx-ry": x * y}
    vector = tilt_vector(tilt, angles)
    normal = Rotation.from_rotvec(np.c_[vector, np.zeros(40)], degrees=True).apply([0, 0, 1])
    assert normal == pytest.approx(whole[angles].apply([0, 0, 1]), abs=1e-12)
    assert tilt_angles(vector, angles) == pytest.approx(tilt, abs=1e-9)


@pytest.mark.parametrize("sense", [1, -1])
def test_poses_turn_as_a_group_and_a_reflection_negates_what_is_odd(sense):
    turning = RotationAugmentation(np.zeros((1, 2)), np.zeros((1, 2)), sense, 0.7, "ry-rx", (3,))
    poses = np.random.default_rng(1).uniform(-20, 20, (9, 4))
    one, two = rotation(5), rotation(9) @ np.diag([1.0, -1.0])
    both = turning.turn_targets(turning.turn_targets(poses, one), two)
    assert turning.turn_targets(poses, two @ one) == pytest.approx(both)
    assert both[:, 2:] == pytest.approx(poses[:, 2:] * [1, -1])
    assert turning.turn_targets(turning.turn_targets(poses, two), two) == pytest.approx(poses)


def test_the_recording_tells_in_which_sense_tilts_turn_and_their_frame():
    rest, moved, poses = drawn(80, 1)
    tilt = poses[:, :2]
    sense, frame = find_frame(rest, moved, tilt)
    assert find_frame(rest, moved, tilt * [1, -1])[0] == -sense != 0
    # the drawn camera is turned by 3 degrees, and a tilt about x moves the image along y
    assert np.degrees(frame) % 180 == pytest.approx(87, abs=2)
    assert find_frame(rest[:, ::-1], moved[..., ::-1], tilt)[0] == -sense
    shuffled = np.random.default_rng(0).permutation(tilt)
    assert find_frame(rest, moved, shuffled)[0] == 0


def test_a_sensor_that_twists_as_it_is_pressed_has_no_reflections():
    rest, moved, poses = drawn(80, 1)
    apart = np.linalg.norm(rest - RotationOperators(rest).middle, axis=1)
    angle = 3.0 * apart / apart.max()  # fields are turned by an angle that grows with the distance
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    twisted = cos * moved + sin * np.stack([-moved[..., 1], moved[..., 0]], axis=-1)
    every = np.ones(80, bool)

    def chosen(fields):
        found = find_rotation(rest, fields, poses, ("rx", "ry", "depth"), True)
        return choose_symmetry(TrainingSet(fields, poses, every, every, 0, found))

    assert chosen(moved).frame_rad is not None
    assert chosen(twisted).frame_rad is None
    assert chosen(twisted).sense == chosen(moved).sense


def train_briefly(samples):
    from palpate.learn.train_member import train_marker_network

    return MarkerNetwork("turned", train_marker_network("turned", samples, epochs=EPOCHS))


def test_turned_presses_teach_what_many_would_and_turned_the_wrong_way_they_do_not():
    needs("torch")
    rest, moved, poses = drawn(400, 2)
    rng = np.random.default_rng(3)
    moved = moved + rng.normal(0.0, 0.3, moved.shape)
    number = np.arange(400)
    lesson = TrainingSet(moved, poses, number < 80, (number >= 80) & (number < 160), 0)
    sense = find_frame(rest, moved[:80], poses[:80, :2])[0]

    def error(part):
        return float(np.sqrt(np.mean((part.predict(moved[160:]) - poses[160:])[:, :2] ** 2)))

    plain = error(train_briefly(lesson))
    turned, wrong = (
        error(train_briefly(replace(lesson, rotation=RotationAugmentation(rest, 0.0 * rest, one))))
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
        turned = rotate_images(picture[None], middle, rotation(6 * number))[0, 0].numpy().astype(float)
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
    turning = RotationAugmentation(places, base, find_frame(places, moved[:80] - lean - base, poses[:80, :2])[0])
    part = train_briefly(replace(lesson, rotation=turning))
    plain = train_briefly(lesson)

    def error(one):
        return float(np.sqrt(np.mean((one.predict(lesson.inputs[140:]) - poses[140:])[:, :2] ** 2)))

    assert error(part) < 0.75 * error(plain)
