"""The twin of a pinned, gel-filled skin, whose presses have no derivative by the skin's thickness."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.calibration import (
    AccuracySpec,
    RobotUncertainty,
    ToleranceSpec,
    build_unit_model,
    identify,
    infer_from_rest,
    predict_accuracy,
)
from palpate.calibration.predict_accuracy import simulate_calibration_presses
from palpate.camera import build_camera
from palpate.core import generator
from palpate.design import MarkerSpec, build_skin, place_markers, skin_from_data
from palpate.fea import Press, WallSpec
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.study import MaterialSpec
from palpate.surrogate import TWIN_DERIVATIVES, BatchTwin, Twin, read_twin, twin_derivatives, write_twin
from presses import build_twin, solve_press

SKIN = build_skin(
    skin_from_data({"kind": "pinned", "height": 19.0, "thickness": 1.5, "base_radius": 19.0, "pin": 2.0})
)
LAYOUT = place_markers(SKIN, MarkerSpec(ring_diameters=(7.0, 14.0, 20.0), diameter=1.2))
CAMERA = build_camera()


def press(tilt_deg: float, derivatives: tuple[str, ...]) -> Press:
    material = MaterialSpec(name="neo-hooke:0.2", gel="neo-hooke:0.05").material()
    wall = WallSpec(tilt_deg=tilt_deg, depth=2.0, depth_step=0.5, contact="no-slip")
    mesh = mesh_skin(SKIN, MeshSpec(filled=True, cells=4, core=1))
    return solve_press(mesh, material, wall, SolverSpec(derivatives=derivatives, edge_share=1.0))


@cache
def presses() -> tuple[Press, ...]:
    return tuple(press(tilt, twin_derivatives(filled=True)) for tilt in (0.0, 3.0, 6.0, 9.0))


@pytest.fixture(scope="module")
def twin() -> Twin:
    return build_twin(list(presses()))


def test_the_twin_has_all_but_the_thickness_and_says_so(twin: Twin, tmp_path: Path) -> None:
    assert twin.left_out == ("thickness",)
    assert twin_derivatives(filled=False) == TWIN_DERIVATIVES
    write_twin(tmp_path / "twin.h5", twin)
    assert read_twin(tmp_path / "twin.h5").left_out == ("thickness",)
    tips, solved = twin.with_markers(LAYOUT.positions), presses()[2]
    moved = solved.positions(LAYOUT.positions)[3] - LAYOUT.positions
    found = tips.evaluate(np.array([6.0, 0.0, solved.depth[3]]), 0.0)
    assert np.abs(found.positions - LAYOUT.positions - moved).max() < 0.04 * np.linalg.norm(moved, axis=1).max()
    assert np.abs(found.jacobian["thickness"]).max() == 0.0
    assert np.abs(found.jacobian["curvature"]).max() > 0.0
    with refused("twin-derivative-left-out", "thickness"):
        tips.evaluate(np.array([6.0, 0.0, 1.5]), 0.0, thickness=0.02)
    needs("torch")
    with refused("twin-derivative-left-out", "thickness"):
        BatchTwin(tips, CAMERA, thickness=0.02)


def test_units_are_predicted_and_identified_without_their_thickness(twin: Twin) -> None:
    tolerance, spec = ToleranceSpec(), AccuracySpec(20, 10, max_tilt_deg=8.0, min_depth=0.8, calibration_presses=3)
    before, after = (
        predict_accuracy(twin, LAYOUT, CAMERA, tolerance, AccuracySpec(20, 10, 0.8, 8.0, calibration_presses=known))
        for known in (0, 3)
    )
    assert 0.0 < after.rmse_deg < before.rmse_deg < 5.0
    posterior = infer_from_rest(twin, LAYOUT, CAMERA.spec, CAMERA.project(LAYOUT.positions), tolerance, 0.05)
    model = build_unit_model(twin, LAYOUT, posterior, tolerance)
    seen = simulate_calibration_presses(model, spec, tolerance, generator(0, "presses"))
    found = identify(model, [each for each, _ in seen], 0.05, RobotUncertainty())
    names = [row["name"] for row in found.rows(tolerance)]
    assert found.left_out == ("thickness",)
    assert "thickness" not in names
    assert "distance" in names
    assert found.posterior.mean["thickness"] == pytest.approx(0.0, abs=1e-9)


def test_presses_that_could_have_a_derivative_must_have_it() -> None:
    with refused("derivative-missing", "curvature"):
        build_twin([press(0.0, ())])
