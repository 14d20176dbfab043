"""What a person waits for, ten cases; `.ci/speed.py` holds their CPU-seconds against the last release."""

import numpy as np
import pytest

from needs import needs
from palpate.calibration import PoseFitter, ToleranceSpec, build_unit_model, infer_from_rest
from palpate.camera import CameraSpec, RenderSpec, build_camera, flat_marker_outlines, render
from palpate.datasets import DatasetSpec, generate_dataset
from palpate.design import MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.fea import WallSpec, solve_press
from palpate.learn import TrainingSpec, train
from palpate.mechanics import EndReason, SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import TWIN_DERIVATIVES, read_twin, write_twin
from palpate.vision import assign_markers, build_pattern, prepare_detector
from presses import build_twin
from presses import solve_press as stored_press
from small_chain import CELLS, DOME, MATERIAL, TILTS, solve

pytestmark = pytest.mark.speed
SKIN = build_skin(DOME)
LAYOUT = place_markers(SKIN, MarkerSpec(count=169))
MARK = place_orientation_mark(SKIN, LAYOUT)
CAMERA = build_camera()


def cost(press):
    return {"iterations": press.newton_iterations, "unknowns": press.unknowns}


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    """Twin of the figures in `docs/results/speed_runs.csv`; another one would not be compared like for like."""
    walls = [
        WallSpec(tilt_deg=tilt, depth=5.0, depth_step=0.5, contact=contact)
        for contact in ("no-slip", 1.4, 0.8, 0.4)
        for tilt in (0.0, 3.0, 6.0, 9.0)
    ]
    mesh, solver = mesh_skin(SKIN, MeshSpec(cells=CELLS)), SolverSpec(derivatives=TWIN_DERIVATIVES)
    path = tmp_path_factory.mktemp("twin") / "twin.h5"
    write_twin(path, build_twin([stored_press(mesh, MATERIAL, wall, solver) for wall in walls]))
    return read_twin(path)


@pytest.fixture(scope="module")
def presses():
    return [solve(tilt) for tilt in TILTS]


@pytest.fixture(scope="module")
def image():
    needs("cv2")
    dots = np.vstack([LAYOUT.positions, MARK])
    normals = SKIN.normal(dots)
    return render(CAMERA, flat_marker_outlines(dots, normals, LAYOUT.diameter), RenderSpec(noise=2.0, blur_px=0.8))


@pytest.mark.parametrize("contact", ["frictionless", "no-slip", 0.5], ids=["frictionless", "no_slip", "friction"])
def test_press(measure, contact):
    """H 20 T 2 under 5° to 8 mm on the default mesh."""
    wall = WallSpec(tilt_deg=5.0, depth=8.0, contact=contact)
    press = measure(lambda: solve_press(mesh_skin(SKIN), MATERIAL, wall), cost)
    assert press.ended == EndReason.DEPTH_REACHED


def test_press_derivatives(measure):
    """A coarse press without slip, with the eleven derivatives that a twin takes."""
    wall, solver = WallSpec(tilt_deg=5.0, depth=4.0), SolverSpec(derivatives=TWIN_DERIVATIVES)
    press = measure(lambda: solve_press(mesh_skin(SKIN, MeshSpec(cells=9)), MATERIAL, wall, solver), cost)
    assert set(press.derivatives) == set(TWIN_DERIVATIVES)


def test_twin_move(measure, twin):
    """Where 169 dots go, and how by pose, friction, thickness, bend and drift, a thousand times."""
    dots = twin.with_markers(LAYOUT.positions)
    poses = np.random.default_rng(1).uniform([-5, -5, 2], [5, 5, 4.5], (1000, 3))
    moved = measure(
        lambda: [dots.evaluate(pose, 0.5, lateral=np.zeros(3)) for pose in poses],
        lambda found: {"iterations": len(found), "unknowns": found[0].jacobian.values.size},
    )
    assert np.isfinite([each.jacobian.values for each in moved]).all()


def test_fit_pose(measure, twin):
    """Pose, friction and their covariance from 120 images of a press, each from where the last one was."""
    dots, rng = twin.with_markers(LAYOUT.positions), np.random.default_rng(2)
    rest = CAMERA.project(LAYOUT.positions)
    belief = infer_from_rest(twin, LAYOUT, CameraSpec(), rest, ToleranceSpec(), 0.05)
    model = build_unit_model(twin, LAYOUT, belief, ToleranceSpec())
    poses = np.column_stack([np.full(120, 4.0), np.full(120, -2.0), np.linspace(1.5, 4.5, 120)])
    seen = [CAMERA.project(dots.evaluate(pose, 1.0).positions) + rng.normal(0, 0.05, rest.shape) for pose in poses]

    def fit():
        fitter = PoseFitter(model, 0.05)
        return [fitter.fit(each) for each in seen]

    fits = measure(
        fit, lambda found: {"iterations": sum(each.steps for each in found), "unknowns": 2 * len(LAYOUT.positions)}
    )
    assert np.abs([each.pose - pose for each, pose in zip(fits, poses, strict=True)]).max() < 0.5


def test_find_dots(measure, image):
    """The dots of an image of 169 and the mark, ten times, detector chosen anew."""
    found = measure(
        lambda: [prepare_detector(image).find(image) for _ in range(10)],
        lambda found: {"iterations": len(found), "unknowns": len(found[0].positions_px)},
    )
    assert len(found[0].positions_px) == len(LAYOUT.positions) + 1


def test_name_dots(measure, image):
    """Which of 169 is which, ten times, pattern included."""
    blobs = prepare_detector(image).find(image).positions_px
    named = measure(
        lambda: [assign_markers(blobs, build_pattern(LAYOUT.positions, CAMERA.project, MARK)) for _ in range(10)],
        lambda found: {"iterations": len(found), "unknowns": int(found[0].found.sum())},
    )
    assert named[0].found.all()
    assert not named[0].ambiguous


def test_generate_dataset(measure, presses):
    """Images of 169 markers at 3000 poses from three presses."""
    spec = DatasetSpec(n_presses=3000, max_tilt_deg=8.0)
    dataset = measure(
        lambda: generate_dataset(presses, LAYOUT, CAMERA, spec),
        lambda found: {"iterations": len(found.poses), "unknowns": found.images_px[0].size},
    )
    assert np.isfinite(dataset.images_px).all()


def test_train(measure, presses):
    """Three perceptrons at once, five epochs over 600 poses, by Adam as in 0.1.0."""
    needs("torch")
    dataset = generate_dataset(presses, LAYOUT, CAMERA, DatasetSpec(n_presses=600, max_tilt_deg=8.0))
    estimator = measure(
        lambda: train(dataset, TrainingSpec(epochs=5, batch=256, clean_share=0.25, matrix_rate=0.0)),
        lambda found: {
            "iterations": 5 * int((~dataset.validation).sum()),
            "unknowns": sum(w.size for w in found.weights),
        },
    )
    assert np.isfinite(estimator.repeat_rmse_deg).all()
