import numpy as np
import pytest

from palpate.camera import CameraSpec, RenderSpec, build_camera, flat_marker_outlines, project_markers, render
from palpate.camera.marker_traces import edge_offsets
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers

DOME = build_skin(DomeSpec())


def dots(count=91):
    layout = place_markers(DOME, MarkerSpec(count=count))
    normals = (layout.positions - [0, 0, DOME.center_z]) / DOME.radius
    return layout.positions, flat_marker_outlines(layout.positions, normals, layout.diameter)


def centroids(image, near, reach=7):
    """Grey centroids of dark dots about known places, without threshold."""
    found = []
    for column, row in near:
        x, y = (
            np.arange(round(column) - reach, round(column) + reach + 1),
            np.arange(round(row) - reach, round(row) + reach + 1),
        )
        weight = 200.0 - image[np.ix_(y, x)].astype(float)
        weight[np.hypot(x[None] - column, y[:, None] - row) > 5.2] = 0.0
        found.append([(weight * x).sum() / weight.sum(), (weight * y[:, None]).sum() / weight.sum()])
    return np.array(found)


@pytest.mark.parametrize(
    "spec", [CameraSpec(), CameraSpec(distortion=(-0.2, 0.05, 0.001, -0.001, 0.0), tilt_x_deg=4)]
)
def test_centroids_are_projection_and_ellipse_bias(spec):
    camera = build_camera(spec)
    centres, edges = dots(37)
    expected = project_markers(camera, edges).centres
    found = centroids(render(camera, edges), expected)
    assert np.abs(found - expected).max() <= 0.02
    assert np.abs(found - camera.project(centres)).max() > 0.02


def test_the_bias_of_a_tilted_disc_is_the_closed_form():
    camera = build_camera(CameraSpec(cx_px=173.0, cy_px=130.0, fx_px=300.0, fy_px=300.0))
    for tilt in np.radians([20.0, 45.0, 60.0]):
        normal = np.array([[np.sin(tilt), 0.0, np.cos(tilt)]])
        centre, radius = np.array([[0.0, 0.0, 12.0]]), 0.75
        bias = project_markers(camera, flat_marker_outlines(centre, normal, 2 * radius)).centres - camera.project(
            centre
        )
        closed = 300.0 * radius**2 * np.sin(tilt) * np.cos(tilt) / 60.0**2
        assert np.abs(bias[0, 0]) == pytest.approx(closed, rel=2e-3)
        assert bias[0, 1] == pytest.approx(0.0, abs=1e-9)


def test_edge_offsets_have_the_area_of_the_disc():
    x, y = edge_offsets(0.75).T
    area = 0.5 * np.abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert area == pytest.approx(np.pi * 0.75**2)


def test_what_spoils_an_image_is_repeatable_and_each_part_shows():
    camera = build_camera()
    _, edges = dots(37)
    clean = render(camera, edges).astype(float)
    assert {clean.max(), clean.min()} == {200.0, 60.0}
    parts = {
        "vignetting": 0.5,
        "unevenness": 0.3,
        "glare": 50.0,
        "blur_px": 1.0,
        "noise": 3.0,
        "dirt": 30,
        "rim": True,
    }
    for name, value in parts.items():
        spoiled = render(camera, edges, RenderSpec(**{name: value}))
        assert np.abs(spoiled - clean).max() > 5, name
        np.testing.assert_array_equal(spoiled, render(camera, edges, RenderSpec(**{name: value})))
    noisy = render(camera, edges, RenderSpec(noise=3.0)).astype(float) - clean
    assert noisy.std() == pytest.approx(3.0, rel=0.05)
    other = render(camera, edges, RenderSpec(noise=3.0, seed=1))
    assert np.any(other != clean + noisy)


def test_a_dot_behind_the_camera_or_outside_is_not_drawn():
    camera = build_camera()
    normal = np.array([[0.0, 0.0, 1.0]])
    for centre in ([[0.0, 0.0, -60.0]], [[500.0, 0.0, 10.0]]):
        assert render(camera, flat_marker_outlines(np.array(centre), normal, 1.5)).min() == 200
