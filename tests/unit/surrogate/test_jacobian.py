import numpy as np
import pytest

from errors import refused
from kinematic_press import PinholeCamera, kinematic_positions, rings, solved
from palpate.surrogate import build_field, image_jacobian

LAYOUT, CAMERA = rings(), PinholeCamera()


def pixels(rx, ry, depth):
    return CAMERA.project(kinematic_positions(LAYOUT.positions, rx, ry, depth)).ravel()


@pytest.mark.parametrize("image", [2, 5, 9])
def test_jacobian_is_the_derivative_of_the_image(image):
    field = build_field(solved(), LAYOUT)
    depth, h = field.depths_mm[image], 1e-4
    found = image_jacobian(field, CAMERA, np.array([[3.0, -5.0]]), image)[0]
    exact = np.stack(
        [
            (pixels(3 + h, -5, depth) - pixels(3 - h, -5, depth)) / (2 * h),
            (pixels(3, -5 + h, depth) - pixels(3, -5 - h, depth)) / (2 * h),
            (pixels(3, -5, depth + h) - pixels(3, -5, depth - h)) / (2 * h),
        ],
        axis=-1,
    )
    assert np.abs(found - exact)[:, :2].max() < 1e-3 * np.abs(exact).max()
    assert np.abs(found - exact)[:, 2].max() < 5e-3 * np.abs(exact).max()


def test_half_the_step_changes_the_jacobian_by_less_than_a_thousandth():
    field = build_field(solved(), LAYOUT)
    poses = np.array([[0.0, 0.0], [6.0, 2.0]])
    coarse, fine = (image_jacobian(field, CAMERA, poses, 5, step) for step in (0.25, 0.125))
    assert np.abs(coarse - fine).max() < 1e-3 * np.abs(fine).max()


def test_there_is_no_derivative_at_the_edge_of_reach_or_across_a_jump():
    presses = [*solved(range(0, 7, 2)), *solved(range(8, 13, 2), inverted_from=4.0)]
    field = build_field(presses, LAYOUT)
    poses = np.array([[3.0, 0.0], [5.9, 0.0], [12.0, 0.0], [10.0, 0.0]])
    known = np.isfinite(image_jacobian(field, CAMERA, poses, 7)).all(axis=(1, 2))
    assert known.tolist() == [True, False, False, True]
    depth_4 = np.isfinite(image_jacobian(field, CAMERA, poses, 4)).all(axis=(1, 2))
    assert depth_4.tolist() == [True, False, False, False]  # at 3.2 mm the 10° press was still flat


def test_the_first_image_has_no_neighbour_before_it():
    with refused("image-few-neighbours"):
        image_jacobian(build_field(solved(), LAYOUT), CAMERA, np.zeros((1, 2)), 0)
