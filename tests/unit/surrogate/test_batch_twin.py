"""The twin in batch against the compiled kernels, pose by pose."""

import subprocess
import sys
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.calibration import ToleranceSpec, build_unit_model, infer_from_rest
from palpate.camera import Camera, CameraSpec, WindowSpec, build_camera
from palpate.camera.lens import Lens
from palpate.design import TILT_SPACE, build_skin, place_markers
from palpate.surrogate import BatchTwin, MarkerTwin, Twin
from small_chain import DOME, MARKERS, small_twin

torch = needs("torch")
SKIN = build_skin(DOME)
LAYOUT = place_markers(SKIN, MARKERS)
LEANING = {"tilt_x_deg": 3.0, "roll_deg": 12.0, "offset_x": 0.7}


@pytest.fixture(scope="module")
def twin() -> Twin:
    return small_twin()


@pytest.fixture(scope="module")
def dots(twin: Twin) -> MarkerTwin:
    return twin.with_markers(LAYOUT.positions)


def draw(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Poses and 1/µ within what was pressed, straight ones, ones at knots, and ones beyond every end."""
    rng = np.random.default_rng(3)
    poses = np.column_stack([rng.uniform(-8, 8, (count, 2)), rng.uniform(0, 5, count)])
    slips = rng.uniform(0, 2.5, count)
    poses[:6] = [[0, 0, 0], [0, 0, 5], [3, 0, 1], [0, -9, 2], [30, 20, 9], [1, 1, -5]]
    slips[:6] = [0, 1 / 1.4, 0, 2.5, 9, -3]
    return poses, slips


def one_by_one(dots: MarkerTwin, camera: Camera, poses: np.ndarray, slips: np.ndarray) -> np.ndarray:
    return np.array([camera.project(dots.evaluate(*each).positions) for each in zip(poses, slips, strict=True)])


@pytest.mark.parametrize(
    "spec",
    [
        CameraSpec(**LEANING),
        CameraSpec(distortion=(-0.2, 0.05, 1e-3, -2e-3, 0.01), **LEANING),
        CameraSpec(lens="kannala-brandt", distortion=(0.05, -0.01, 2e-3, 1e-4), **LEANING),
        CameraSpec(window=WindowSpec(thickness=3.0), **LEANING),
    ],
)
def test_pixels_are_those_of_the_kernels(dots: MarkerTwin, spec: CameraSpec) -> None:
    camera, (poses, slips) = build_camera(spec), draw(300)
    found = BatchTwin(dots, camera).pixels(poses, slips).numpy()
    assert found == pytest.approx(one_by_one(dots, camera, poses, slips), abs=1e-9)


def test_forces_and_positions_are_those_of_the_kernels(dots: MarkerTwin) -> None:
    poses, slips = draw(300)
    batch = BatchTwin(dots, build_camera())
    moved = [dots.evaluate(*each) for each in zip(poses, slips, strict=True)]
    assert batch.forces(poses, slips).numpy() == pytest.approx(np.array([each.force for each in moved]), abs=1e-12)
    assert batch.positions(poses, slips).numpy() == pytest.approx(
        np.array([each.positions for each in moved]), abs=1e-11
    )


def test_pieces_join_without_a_seam(dots: MarkerTwin, monkeypatch: pytest.MonkeyPatch) -> None:
    poses, slips = draw(25)
    batch = BatchTwin(dots, build_camera())
    whole = batch.pixels(poses, slips)
    monkeypatch.setattr("palpate.surrogate.batch_twin._PIECE", {"cpu": 10})
    assert batch.pixels(poses, slips).numpy() == pytest.approx(whole.numpy(), abs=1e-10)


def test_pixels_and_forces_together_equal_each_alone(twin: Twin) -> None:
    poses, inverse_frictions = draw(25)
    batch = BatchTwin(twin.with_markers(LAYOUT.positions), build_camera())
    pixels, forces = batch.evaluate(poses, inverse_frictions)
    assert (pixels == batch.pixels(poses, inverse_frictions)).all()
    assert (forces == batch.forces(poses, inverse_frictions)).all()


def test_a_unit_looks_as_its_model_has_it(twin: Twin) -> None:
    """Dots where the rest image shows them, centres of their traces, and a thicker wall."""
    rest = build_camera(CameraSpec(offset_x=0.2, tilt_y_deg=0.4)).project(LAYOUT.positions)
    rest[5] = np.nan
    belief = infer_from_rest(twin, LAYOUT, CameraSpec(), rest, ToleranceSpec(), 0.05)
    mean = belief.mean.replace(thickness=0.05)
    model = build_unit_model(twin, LAYOUT, replace(belief, mean=mean), ToleranceSpec())
    poses, slips = draw(40)
    found = BatchTwin(model.outlines, model.camera, 6, 0.05).pixels(poses, slips).numpy()
    looked = np.array([model.predict(*each, unit=False).pixels for each in zip(poses, slips, strict=True)])
    assert np.flatnonzero(np.isnan(looked[0, :, 0])).tolist() == [5]
    assert found[:, model.visible] == pytest.approx(looked[:, model.visible], abs=1e-9)
    plain = BatchTwin(model.outlines, model.camera, 6).pixels(poses, slips).numpy()
    assert np.abs(plain - found)[:, model.visible].max() > 1e-3


def test_torch_differentiates_through_the_twin(dots: MarkerTwin) -> None:
    pose, slip = torch.tensor([[3.0, -2.0, 1.7]], dtype=torch.float64), torch.tensor([0.8], dtype=torch.float64)
    batch = BatchTwin(dots, build_camera())
    by_pose, by_slip = torch.autograd.functional.jacobian(batch.positions, (pose, slip))
    moved = dots.evaluate(pose[0].numpy(), 0.8)
    assert by_pose[0, :, :, 0].numpy() == pytest.approx(moved.jacobian[TILT_SPACE.names], abs=1e-9)
    assert by_slip[0, :, :, 0].numpy() == pytest.approx(moved.jacobian["inverse_friction"], abs=1e-9)


def test_torch_differentiates_through_the_window(dots: MarkerTwin) -> None:
    batch = BatchTwin(dots, build_camera(CameraSpec(window=WindowSpec(thickness=3.0), **LEANING)))
    pose, slip = torch.tensor([[3.0, -2.0, 1.7]], dtype=torch.float64), torch.tensor([0.8], dtype=torch.float64)
    by_depth = torch.autograd.functional.jacobian(lambda pose: batch.pixels(pose, slip), pose)[0, :, :, 0, 2]
    step = torch.tensor([0.0, 0.0, 1e-4], dtype=torch.float64)
    differences = (batch.pixels(pose + step, slip) - batch.pixels(pose - step, slip))[0] / 2e-4
    assert by_depth.numpy() == pytest.approx(differences.numpy(), abs=1e-5)
    upright = BatchTwin(dots, build_camera(CameraSpec(window=WindowSpec(thickness=3.0))))
    straight = torch.tensor([[0.0, 0.0, 1.7]], dtype=torch.float64)  # the apex stays on the camera's axis
    by_depth = torch.autograd.functional.jacobian(lambda pose: upright.pixels(pose, slip), straight)[0, :, :, 0, 2]
    assert torch.isfinite(by_depth).all()


def test_single_precision_is_good_to_a_thousandth_of_a_pixel(dots: MarkerTwin) -> None:
    camera, (poses, slips) = build_camera(), draw(300)
    found = BatchTwin(dots, camera, dtype="float32").pixels(poses, slips)
    assert found.dtype == torch.float32
    assert found.numpy() == pytest.approx(one_by_one(dots, camera, poses, slips), abs=1e-3)


@dataclass(frozen=True)
class Mirror(Lens):
    """A lens from another package, of numpy alone."""

    name: ClassVar[str] = "mirror"
    max_radius = float("inf")

    def distort(self, points: np.ndarray) -> np.ndarray:
        return np.negative(np.asarray(points))

    undistort = distort

    def mirrored(self) -> "Mirror":
        return self


def test_a_lens_that_the_batch_does_not_know_is_refused(dots: MarkerTwin) -> None:
    with refused("lens-not-in-batch", "mirror"):
        BatchTwin(dots, replace(build_camera(), lens=Mirror()))


def test_the_room_of_twins_opens_without_torch() -> None:
    code = "import sys, palpate.surrogate; print('torch' in sys.modules)"
    shown = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert shown.stdout.strip() == "False"
