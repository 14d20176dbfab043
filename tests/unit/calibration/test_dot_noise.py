"""The law of a dot's noise, held against the package's own detector on degraded images of the bench."""

import numpy as np
import pytest

from palpate.calibration import Deviation
from palpate.calibration.noise import NOISE_DOT_PX, NOISE_PX, layout_noise, noise_by_diameter
from palpate.camera import CameraSpec, build_camera, project_markers, render
from palpate.core import generator
from palpate.design import Design, DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.simulation import DEGRADED, SimulatedUnit
from palpate.vision import DetectSpec, prepare_detector

SKIN = build_skin(DomeSpec())


@pytest.mark.parametrize(("diameter", "distance"), [(0.8, 54.0), (1.0, 48.0), (1.6, 48.0), (2.5, 54.0)])
def test_the_law_is_what_the_detector_shows_on_degraded_images(diameter: float, distance: float) -> None:
    layout = place_markers(SKIN, MarkerSpec(count=37, diameter=diameter))
    rng, errors, detector = generator(1, "law"), [], None
    for number in range(10):
        x, y = rng.uniform(-0.3, 0.3, 2)
        scene = SimulatedUnit(
            Design.of_skin(SKIN, layout, CameraSpec(distance=distance)), Deviation(offset_x=x, offset_y=y), DEGRADED
        )
        image = render(scene.camera, scene.edges, DEGRADED.model_copy(update={"noise_seed": number}))
        truth, sizes = project_markers(scene.camera, scene.edges[:-1])
        size = float(np.median(sizes))
        detector = detector or prepare_detector(image, DetectSpec(polarity="dark", diameter_px=size))
        found = detector.find(image).positions_px
        off = truth[:, None] - found
        nearest = np.linalg.norm(off, axis=-1).argmin(axis=1)
        errors.append(off[np.arange(len(truth)), nearest])
    errors = np.array(errors)
    errors[np.linalg.norm(errors, axis=-1) > 1.5] = np.nan
    mean = np.nanmedian(errors, axis=0)
    own = 1.4826 * np.nanmedian(np.abs(errors - mean), axis=(0, 2))
    measured = float(np.hypot(np.sqrt(np.nanmean(own**2)), 1.4826 * np.nanmedian(np.abs(mean))))
    law = float(np.median(layout_noise(SKIN, layout, build_camera(CameraSpec(distance=distance)))))
    assert law == pytest.approx(measured, rel=0.25)


def test_a_small_dot_is_found_worse_as_the_bound_says_and_the_usual_one_as_before() -> None:
    assert noise_by_diameter(np.array([NOISE_DOT_PX]))[0] == pytest.approx(NOISE_PX, rel=1e-12)
    small, half = noise_by_diameter(np.array([2.0, 1.0]))
    assert half / small == pytest.approx(np.sqrt(2.0), rel=0.03)
    assert noise_by_diameter(np.array([20.0]))[0] > noise_by_diameter(np.array([6.0]))[0], (
        "light is uneven across a large dot"
    )


def test_dots_of_a_millimetre_at_48_mm_have_the_noise_that_all_had() -> None:
    layout = place_markers(SKIN, MarkerSpec(diameter=1.0))
    noise = layout_noise(SKIN, layout, build_camera(CameraSpec()))
    assert len(noise) == 169
    assert np.abs(noise / NOISE_PX - 1.0).max() < 0.01
