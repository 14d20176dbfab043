"""A training whose units differ from the design."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

from errors import refused
from kinematic_press import RADIUS, KinematicPress, PinholeCamera, kinematic_positions, rings, solved
from palpate.camera import CameraSpec, build_camera
from palpate.datasets import (
    DatasetSpec,
    PerturbedPresses,
    RandomisationSpec,
    generate_dataset,
    read_dataset,
    write_dataset,
)
from palpate.design import Dome, MarkerLayout

LAYOUT, CAMERA = rings(), PinholeCamera()
SLIP, THICK = 0.3, 0.1


@dataclass
class SlippingPress(KinematicPress):
    """The dome turns less with the wall the more it slips, and sinks more the thicker it is."""

    slip: float = 0.0
    thick: float = 0.0

    def positions(self, points):
        held = super().positions(points)
        return points + (held - points) * np.array([1 - self.slip, 1 - self.slip, 1 + self.thick])


def group(**changes):
    return [SlippingPress(float(tilt), **changes) for tilt in range(0, 13, 2)]


def spec(**randomise):
    return DatasetSpec(n_presses=60, randomise=RandomisationSpec(**randomise))


def test_a_spec_without_randomisation_is_written_as_before_there_was_any():
    assert set(DatasetSpec().model_dump(mode="json")) == {
        "poses",
        "n_presses",
        "max_tilt_deg",
        "dropped_images",
        "jitter_px",
        "normalisation",
        "validation_fraction",
        "seed",
    }
    varied = spec(frictions=(0.7, 1.2))
    assert DatasetSpec.model_validate_json(varied.model_dump_json()) == varied
    assert varied.model_dump(mode="json")["randomise"]["frictions"] == [1.2, 0.7]


def test_nothing_varied_gives_the_same_images():
    plain = generate_dataset(solved(), LAYOUT, CAMERA, DatasetSpec(n_presses=60))
    assert np.array_equal(generate_dataset(solved(), LAYOUT, CAMERA, spec()).images_px, plain.images_px)


def test_every_slip_between_the_pressed_ones_is_seen():
    chosen = spec(frictions=(1.2, 0.6))
    relatives = PerturbedPresses(frictions=(group(slip=SLIP), group(slip=2 * SLIP)))
    dataset = generate_dataset(solved(), LAYOUT, CAMERA, chosen, relatives)
    slips = []
    for image, (rx, ry, depth) in zip(dataset.images_px[::8], dataset.poses[::8], strict=True):
        moved = kinematic_positions(LAYOUT.positions, rx, ry, depth) - LAYOUT.positions
        tried = np.linspace(0, 2 * SLIP, 121)
        misses = [
            np.abs(CAMERA.project(LAYOUT.positions + moved * [1 - slip, 1 - slip, 1]) - image).max() for slip in tried
        ]
        slips.append(tried[np.argmin(misses)])
        assert min(misses) < 0.05
    assert np.histogram(slips, 3, (0, 2 * SLIP))[0].min() > 8
    assert dataset.solved_presses == 21


def test_walls_thinner_and_thicker_are_seen():
    chosen = spec(thickness=0.05)
    dataset = generate_dataset(
        solved(), LAYOUT, CAMERA, chosen, PerturbedPresses(thicknesses=(group(thick=-THICK), group(thick=THICK)))
    )
    deep = dataset.poses[:, 2] > 7.9
    plain = generate_dataset(solved(), LAYOUT, CAMERA, DatasetSpec(n_presses=60))
    ratio = dataset.images_px[deep, 0] - plain.images_px[deep, 0]
    assert ratio.std() > 0
    assert np.abs(dataset.travel_mm[deep] / plain.travel_mm[deep] - 1).max() < THICK


def test_presses_that_are_asked_for_must_be_there():
    with refused("dataset-variation-missing", "friction", "1", "0"):
        generate_dataset(solved(), LAYOUT, CAMERA, spec(frictions=(1.0,)))
    shallow = PerturbedPresses(frictions=(group(reached=4.0),))
    with refused("dataset-variation-short", "4"):
        generate_dataset(solved(), LAYOUT, CAMERA, spec(frictions=(1.0,)), shallow)


def test_units_on_different_branches_are_left_out_with_the_reason():
    snapped = PerturbedPresses(frictions=(group(inverted_from=5.0),))
    dataset = generate_dataset(solved(), LAYOUT, CAMERA, spec(frictions=(1.0,)), snapped)
    assert dataset.dropped == {"units on different branches": 60 * 4}


def test_a_misprinted_dot_moves_as_the_surface_beneath_it_and_looks_as_designed_at_rest():
    layout = MarkerLayout(positions=LAYOUT.positions, diameter=1.5)
    presses = solved()
    for press in presses:
        press.mesh = SimpleNamespace(skin=Dome(RADIUS, RADIUS, 2.0))
    camera = build_camera()
    dataset = generate_dataset(presses, layout, camera, spec(dot=0.2))
    plain = generate_dataset(presses, layout, camera, DatasetSpec(n_presses=60))
    off = np.abs(dataset.images_px - plain.images_px)
    deep = dataset.poses[:, 2] > 7.9
    assert 0.02 < off[deep].max() < 1.0
    assert np.array_equal(dataset.rest_px, plain.rest_px)
    # the displacement itself: that of the surface a little aside, against the closed form
    from palpate.datasets.randomise import randomise_field

    field = randomise_field(presses, layout, PerturbedPresses(), spec(dot=0.2))
    step = np.full((1, len(layout.positions), 2), 0.1)
    there = replace(field, tangent_offsets=step)
    rest = there.rest_of(np.array([0]))[0]
    assert np.linalg.norm(rest - layout.positions, axis=1) == pytest.approx(np.full(37, 0.1 * np.sqrt(2)), rel=0.02)
    moved = there.positions(np.array([[5.0, 2.0]]), np.array([0]), 9)[0]
    on_sphere = rest * RADIUS / np.linalg.norm(rest, axis=1, keepdims=True)
    assert np.abs(moved - kinematic_positions(on_sphere, 5.0, 2.0, 8.0)).max() < 0.004


def test_another_camera_under_every_unit_is_seen_after_rest_was_taken_off():
    layout = MarkerLayout(positions=LAYOUT.positions, diameter=1.5)
    presses = solved()
    for press in presses:
        press.mesh = SimpleNamespace(skin=Dome(RADIUS, RADIUS, 2.0))
    chosen = spec(camera_offset=0.5, camera_distance=0.5, camera_tilt_deg=1.0, focal=0.003)
    varied = generate_dataset(presses, layout, build_camera(CameraSpec()), chosen)
    plain = generate_dataset(presses, layout, build_camera(CameraSpec()), DatasetSpec(n_presses=60))
    off = np.abs(varied.images_px - plain.images_px)
    assert 0.05 < off.max() < 3.0
    assert off[plain.poses[:, 2] < 2.5].mean() < 0.5 * off[plain.poses[:, 2] > 7.9].mean()


def test_a_varied_dataset_survives_its_file(tmp_path):
    made = generate_dataset(
        solved(), LAYOUT, CAMERA, spec(frictions=(1.0,)), PerturbedPresses(frictions=(group(slip=SLIP),))
    )
    write_dataset(tmp_path / "d.h5", made)
    assert read_dataset(tmp_path / "d.h5").spec == made.spec


def test_frictions_are_numbers_given_once():
    with refused("frictions-malformed"):
        RandomisationSpec(frictions=(1.0, 1.0))


def test_a_press_has_the_obstacle_of_the_study_or_one_of_the_others():
    holes = ({"kind": "plate", "hole_diameter": 4.0}, {"kind": "plate", "hole_diameter": "8 mm", "offset": -1.0})
    others = PerturbedPresses(obstacles=(group(slip=0.2), group(slip=0.5)))
    varied = generate_dataset(group(), LAYOUT, CAMERA, spec(obstacles=holes), others)
    alone = [generate_dataset(group(slip=by), LAYOUT, CAMERA, DatasetSpec(n_presses=60)) for by in (0.0, 0.2, 0.5)]
    same = np.array([np.isclose(varied.images_px, one.images_px).all(axis=(1, 2)) for one in alone])
    moved = varied.poses[:, 2] > 0
    assert (same[:, moved].sum(axis=0) == 1).all()
    for press in np.unique(varied.press):
        assert len(np.unique(same[:, moved & (varied.press == press)], axis=1).T) == 1
    assert (same[:, moved].mean(axis=1) > 0.15).all()
    with refused("dataset-variation-missing"):
        generate_dataset(group(), LAYOUT, CAMERA, spec(obstacles=holes), PerturbedPresses(obstacles=(group(),)))


def test_obstacles_are_written_only_if_there_are_some():
    assert "obstacles" not in spec(frictions=(0.7,)).model_dump(mode="json")["randomise"]
    varied = spec(obstacles=({"kind": "plate", "hole_diameter": "4 mm"},))
    assert varied.model_dump(mode="json")["randomise"]["obstacles"] == [{"kind": "plate", "hole_diameter": 4.0}]
    assert DatasetSpec.model_validate_json(varied.model_dump_json()) == varied


@pytest.mark.parametrize(
    "obstacle",
    [
        {"kind": "anvil"},
        {"kind": "plate", "hole_diameter": -1.0},
        {"kind": "plate", "depth": 3.0},
        {"kind": "plate", "tilt_deg": 3.0},
        {"kind": "plate", "contact": 0.5},
    ],
)
def test_wrong_obstacles_are_refused(obstacle):
    with pytest.raises(ValidationError) as caught:
        RandomisationSpec(obstacles=(obstacle,))
    assert caught.value.errors()[0]["loc"] == ("obstacles",)
