import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from errors import refused
from palpate.camera import Camera, CameraSpec, build_camera, camera_preset, list_presets
from palpate.design import Dome, MarkerSpec, place_markers

BARREL = (-0.26509039, -0.046742201, 0.0018330155, -0.00031469161, 0.25231221)
POSED = CameraSpec(distortion=BARREL, offset_x=1.5, offset_y=-2.0, tilt_x_deg=3.0, tilt_y_deg=-4.0, roll_deg=30.0)
DOME = Dome(20.0, 20.0, 2.0)


def markers() -> NDArray[np.float64]:
    return place_markers(DOME, MarkerSpec(count=169)).positions


def project_by_opencv(camera: Camera, points: NDArray[np.float64]) -> NDArray[np.float64]:
    spec = camera.spec
    matrix = np.array([[spec.fx_px, 0, spec.cx_px], [0, spec.fy_px, spec.cy_px], [0, 0, 1.0]])
    rotation, _ = cv2.Rodrigues(camera.camera_from_dome)
    shift = -camera.camera_from_dome @ camera.origin
    pixels, _ = cv2.projectPoints(points, rotation, shift, matrix, np.array(spec.distortion))
    return np.asarray(pixels).reshape(-1, 2)


@pytest.mark.parametrize("spec", [CameraSpec(), CameraSpec(distortion=BARREL), POSED])
def test_projection_agrees_with_opencv(spec: CameraSpec) -> None:
    camera = build_camera(spec)
    np.testing.assert_allclose(camera.project(markers()), project_by_opencv(camera, markers()), atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(
    k1=st.floats(-0.3, 0.3),
    k2=st.floats(-0.1, 0.1),
    p1=st.floats(-0.01, 0.01),
    p2=st.floats(-0.01, 0.01),
    k3=st.floats(-0.05, 0.05),
)
def test_any_lens_agrees_with_opencv_and_goes_back(k1: float, k2: float, p1: float, p2: float, k3: float) -> None:
    camera = build_camera(CameraSpec(distortion=(k1, k2, p1, p2, k3)))
    points = markers()
    pixels = camera.project(points)
    np.testing.assert_allclose(pixels, project_by_opencv(camera, points), atol=1e-9)
    arm = points - camera.origin
    np.testing.assert_allclose(
        camera.back_project(pixels), arm / np.linalg.norm(arm, axis=1, keepdims=True), atol=1e-8
    )


def test_a_posed_camera_goes_back_to_the_same_rays() -> None:
    camera = build_camera(POSED)
    arm = markers() - camera.origin
    rays = camera.back_project(camera.project(markers()))
    np.testing.assert_allclose(rays, arm / np.linalg.norm(arm, axis=1, keepdims=True), atol=1e-8)


def test_the_nominal_camera_has_the_domes_axes() -> None:
    camera = build_camera()
    np.testing.assert_allclose(camera.camera_from_dome, np.eye(3))
    np.testing.assert_allclose(camera.origin, [0, 0, -48])
    along_x, along_y = camera.project([[1.0, 0, 0], [0, 1.0, 0]])
    np.testing.assert_allclose(along_x, [174.91 + 297.38 / 48, 128.22])
    np.testing.assert_allclose(along_y, [174.91, 128.22 + 297.60 / 48])


def test_every_marker_of_the_papers_sensor_is_visible() -> None:
    assert build_camera().visible(markers(), DOME).all()


def test_points_behind_the_camera_have_no_pixel_and_are_not_seen() -> None:
    camera = build_camera()
    assert np.isnan(camera.project([0.0, 0.0, -60.0])).all()
    assert not camera.visible([0.0, 0.0, -60.0], DOME)


def test_points_outside_the_image_are_not_seen() -> None:
    np.testing.assert_array_equal(build_camera().visible([[0, 0, 0], [40.0, 0, 0]]), [True, False])


def test_the_rim_hides_what_bulges_beyond_it() -> None:
    low = [21.4, 0.0, 5.0]
    camera = build_camera(CameraSpec(distance=30, fx_px=150, fy_px=150))
    assert camera.visible(low)
    assert camera.visible(low, Dome(30.0, 21.0, 2.0))
    assert not camera.visible(low, Dome(30.0, 15.0, 2.0))


def test_where_the_lens_folds_nothing_is_seen_and_nothing_traced_back() -> None:
    camera = build_camera(CameraSpec(distortion=(-1.0, 0, 0, 0, 0), distance=20))
    assert camera.lens.max_radius == pytest.approx(1 / np.sqrt(3))
    beyond = [13.0, 0.0, 0.0]
    assert not camera.visible(beyond)
    with refused("lens-folds", "0.577"):
        camera.back_project([345.0, 128.0])


def test_presets_are_known_by_name() -> None:
    assert list_presets() == ("davis346",)
    assert (camera_preset("davis346").width_px, camera_preset("davis346").height_px) == (346, 260)
    with refused("camera-unknown", "davis346"):
        camera_preset("gopro")


def test_the_dump_of_browns_lens_is_as_before_there_was_another() -> None:
    assert "lens" not in CameraSpec().model_dump()
    assert CameraSpec(distortion=BARREL).model_dump()["distortion"] == BARREL
    fisheye = CameraSpec(lens="kannala-brandt")
    assert fisheye.distortion == (0.0,) * 4
    assert fisheye.model_dump()["lens"] == "kannala-brandt"


def test_an_unknown_lens_is_refused_with_those_there_are() -> None:
    with refused("kind-unknown", "fish", "brown", "kannala-brandt"):
        CameraSpec(lens="fish")
