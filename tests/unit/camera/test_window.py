"""Refraction at a window: against rays traced forward by Snell's law, which share nothing with the iteration."""

import numpy as np
import pytest
from numpy.typing import NDArray

from errors import refused
from palpate.calibration.camera_derivatives import CameraDerivatives
from palpate.camera import (
    Camera,
    CameraSpec,
    WindowSpec,
    build_camera,
    flat_marker_outlines,
    project_markers,
    read_window,
)
from palpate.cli.unit import UnitFlags
from palpate.design import ConeSpec, Dome, MarkerSpec, place_markers
from palpate.vision import MarkerAssignment, register_dome

LEANING = {"distance": 24.0, "offset_x": 1.5, "offset_y": -2.0, "tilt_x_deg": 4.0, "tilt_y_deg": -5.0, "roll_deg": 30}
PAD = CameraSpec(**LEANING, distortion=(-0.2, 0.05, 1e-3, -2e-3, 0.0), window=WindowSpec(thickness=2.0))
WINDOWS = [
    WindowSpec(thickness=2.0),
    WindowSpec(thickness=6.0, index=1.52),
    WindowSpec(thickness=0.0),
    WindowSpec(thickness=4.0, gel_index=1.0),
    WindowSpec(thickness=3.0, index=1.3, gel_index=1.6),
]
POINTS = np.random.default_rng(0).uniform([-12.0, -12.0, 0.0], [12.0, 12.0, 6.0], (300, 3))


def behind(window: WindowSpec | None) -> Camera:
    return build_camera(PAD.model_copy(update={"window": window}))


def refract(rays: NDArray[np.float64], ratio: float) -> NDArray[np.float64]:
    """Snell's law for unit vectors at a plane across z; `ratio` is the index before it over that behind."""
    across = ratio * rays[:, :2]
    return np.column_stack([across, np.sqrt(1.0 - (across**2).sum(axis=1))])


def trace(camera: Camera, pixels: NDArray[np.float64], window: WindowSpec) -> tuple[NDArray[np.float64], ...]:
    """Rays forward from the pinhole: to the window, through it, into the gel; where they enter it and how they go."""
    rays = camera.back_project(pixels)
    at = camera.origin + (-window.thickness - camera.origin[2]) / rays[:, 2:] * rays
    rays = refract(rays, 1.0 / window.index)
    at = at + window.thickness / rays[:, 2:] * rays
    return at, refract(rays, window.index / window.gel_index)


def miss(at: NDArray[np.float64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances (n,) mm of the points from rays."""
    return np.linalg.norm(np.cross(POINTS - at, rays), axis=1)


@pytest.mark.parametrize("window", WINDOWS)
def test_rays_traced_from_the_pinhole_meet_the_points(window: WindowSpec) -> None:
    camera = behind(window)
    at, rays = trace(camera, camera.project(POINTS), window)
    assert miss(at, rays).max() < 1e-9
    starts, sight = camera.sight_lines(camera.project(POINTS))
    assert starts == pytest.approx(at, abs=1e-12)
    assert sight == pytest.approx(rays, abs=1e-12)


def test_rays_by_another_index_or_by_a_camera_without_refraction_miss_the_points() -> None:
    camera, window = behind(WINDOWS[0]), WINDOWS[0]
    other = window.model_copy(update={"gel_index": 1.40})
    assert np.median(miss(*trace(camera, camera.project(POINTS), other))) > 3e-3
    blind = behind(None).project(POINTS)
    assert np.median(miss(*trace(camera, blind, window))) > 0.2
    assert np.median(np.linalg.norm(blind - camera.project(POINTS), axis=1)) > 3.0


def test_near_the_axis_a_point_seems_as_deep_as_its_depth_over_the_index() -> None:
    camera = build_camera(CameraSpec(distance=24, window=WindowSpec(thickness=3, index=1.52, gel_index=1.41)))
    aside = 1e-3
    column = camera.project([aside, 0.0, 4.0])[0] - camera.project([0.0, 0.0, 4.0])[0]
    apparent = 21.0 + 3.0 / 1.52 + 4.0 / 1.41
    assert column == pytest.approx(camera.spec.fx_px * aside / apparent, rel=1e-6)


def test_a_window_as_dense_as_air_is_none() -> None:
    air = WindowSpec(thickness=5.0, index=1.0, gel_index=1.0)
    assert behind(air).project(POINTS) == pytest.approx(behind(None).project(POINTS), abs=1e-9)
    starts, rays = behind(None).sight_lines([[100.0, 80.0]])
    assert starts == pytest.approx(behind(None).origin[None])
    assert rays == pytest.approx(behind(air).sight_lines([[100.0, 80.0]])[1], abs=1e-12)


def test_what_stands_before_or_in_the_window_is_seen_without_a_jump() -> None:
    camera = build_camera(CameraSpec(distance=24, window=WindowSpec(thickness=3)))
    heights = np.array([-3.0, 0.0])[:, None] + [-1e-9, 1e-9]
    pixels = camera.project(np.stack([np.full_like(heights, 5.0), np.zeros_like(heights), heights], axis=-1))
    assert pixels[:, 0] == pytest.approx(pixels[:, 1], abs=1e-6)
    straight = build_camera(CameraSpec(distance=24)).project([5.0, 0.0, -4.0])
    assert camera.project([5.0, 0.0, -4.0]) == pytest.approx(straight)
    assert np.isnan(camera.project([0.0, 0.0, -30.0])).all()
    assert not camera.visible([0.0, 0.0, -30.0])


def test_the_rim_hides_by_the_bent_line_of_sight() -> None:
    """A straight line to this point passes the base 14.9 mm from the axis, one that is steeper in the gel 15.2 mm."""
    bulging, low = Dome(20.0, 15.0, 1.0), [16.0, 0.0, 1.5]
    wide = CameraSpec(distance=20, fx_px=150, fy_px=150)
    assert build_camera(wide).visible(low, bulging)
    gel = build_camera(wide.model_copy(update={"window": WindowSpec(thickness=0.0)}))
    assert not gel.visible(low, bulging)
    assert gel.visible(low)


def test_derivatives_by_the_camera_are_those_of_cameras_moved_past_the_window() -> None:
    """Against differences over other steps; the rule for a camera in air, dots that move the other way, is off."""
    names = ("offset_x", "offset_y", "distance", "tilt_x_deg", "roll_deg")
    steps = np.array([1e-3, 1e-3, 1e-3, 1e-2, 1e-2])
    camera = behind(WINDOWS[1])

    def moved(name: str, by: float) -> Camera:
        return build_camera(camera.spec.model_copy(update={name: getattr(camera.spec, name) + by}))

    pairs = [(moved(name, step), moved(name, -step)) for name, step in zip(names, steps, strict=True)]
    found = CameraDerivatives(camera, pairs, steps).jacobian(POINTS)
    wider = [
        (moved(name, 20 * step).project(POINTS) - moved(name, -20 * step).project(POINTS)) / (40 * step)
        for name, step in zip(names, steps, strict=True)
    ]
    assert found == pytest.approx(np.stack(wider, axis=-1), abs=2e-3)
    sink = np.array([0.0, 0.0, 0.02])
    sunk = (camera.project(POINTS + sink) - camera.project(POINTS - sink)) / 0.04
    assert np.abs(found[..., 2] - sunk).max() > 0.5


def test_the_camera_is_registered_behind_its_window() -> None:
    """Of dots drawn behind a window its pose comes out; a camera that knows none is laid more than 1 mm nearer."""
    skin = ConeSpec(height=3.5, base_radius=12.9, thickness=0.5, flat_radius=10, edge_radius=2).build()
    layout = place_markers(skin, MarkerSpec(count=61, diameter=0.6))
    nominal = CameraSpec(distance=24, window=WINDOWS[0])
    true = build_camera(nominal.model_copy(update={"distance": 24.3, "offset_x": 0.2, "tilt_y_deg": 0.8}))
    seen = project_markers(true, flat_marker_outlines(layout.positions, skin.normal(layout.positions), 0.6)).centres
    naming = MarkerAssignment(np.arange(len(seen)), seen, np.ones(len(seen), bool), 0.0, False, (), -1, 0.0)
    found = register_dome(naming, layout, skin, nominal).camera.spec
    assert found.window == nominal.window
    assert found.distance == pytest.approx(24.3, abs=2e-3)
    assert found.offset_x == pytest.approx(0.2, abs=2e-3)
    assert found.tilt_y_deg == pytest.approx(0.8, abs=5e-3)
    blind = register_dome(naming, layout, skin, nominal.model_copy(update={"window": None})).camera.spec
    assert abs(blind.distance - 24.3) > 1.0


def test_a_camera_without_a_window_is_written_as_before_there_was_one() -> None:
    assert "window" not in CameraSpec().model_dump()
    assert CameraSpec.model_validate_json(PAD.model_dump_json()) == PAD
    assert build_camera(CameraSpec()).window is None


def test_a_unit_at_the_command_line_has_its_window() -> None:
    assert UnitFlags(window="3,1.52").unit().lens == CameraSpec(window=WindowSpec(thickness=3.0, index=1.52))
    assert UnitFlags().unit().lens is None
    for text in ("thick", "2,1.49,1.41,1", "2,0.5", ""):
        with refused("window-malformed"):
            read_window(text)


def test_a_window_that_reaches_the_camera_is_refused() -> None:
    with refused("window-beyond-camera", "25", "24"):
        CameraSpec(distance=24, window={"thickness": "25 mm"})
