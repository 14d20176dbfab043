"""Reading a dome that may stand in two states, held against presses of either that the twin has not seen."""

from dataclasses import replace

import numpy as np
import pytest

from palpate.calibration import Deviation, PoseFit, PoseFitter, ToleranceSpec, build_unit_model, infer_from_rest
from palpate.camera import CameraSpec, RenderSpec, build_camera, marker_outlines, project_markers
from palpate.design import Design, DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import Branch, Press, WallSpec
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import Unit, open_sensor
from palpate.simulation.simulated_unit import SimulatedUnit
from palpate.surrogate import TWIN_DERIVATIVES, Twin, read_twin, write_twin
from palpate.vision import MotionModel, Tracker
from presses import build_twin, solve_press

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")
DOME = build_skin(DomeSpec(height=20, thickness=1))
LAYOUT = place_markers(DOME, MarkerSpec(count=169))
EDGES = marker_outlines(DOME, LAYOUT.positions, LAYOUT.diameter).reshape(-1, 3)
CAMERA = build_camera()
NOISE = 0.02
DEPTH = 6.0
TILTS = (0.0, 4.0, 8.0)


def press(tilt: float, branch: Branch, names: tuple[str, ...] = (), step: float = 0.5) -> Press:
    wall = WallSpec(tilt_deg=tilt, azimuth_deg=70.0, depth=DEPTH, depth_step=step)
    mesh = mesh_skin(DOME, MeshSpec(cells=9, core=2 if branch is Branch.INVERTED else 1))
    return solve_press(mesh, ECOFLEX, wall, SolverSpec(derivatives=names, edge_share=1.0), branch)


@pytest.fixture(scope="module")
def flat() -> list[Press]:
    return [press(tilt, Branch.FLAT, TWIN_DERIVATIVES) for tilt in TILTS]


@pytest.fixture(scope="module")
def twin(flat: list[Press]) -> Twin:
    return build_twin(flat, [press(tilt, Branch.INVERTED, TWIN_DERIVATIVES) for tilt in TILTS])


@pytest.fixture(scope="module")
def other() -> Press:
    """An inverted press at a tilt that the twin has not seen, and at other depths."""
    return press(6.0, Branch.INVERTED, step=0.7)


def shot(edges: np.ndarray) -> np.ndarray:
    """Centres of the traces of dots with these edges."""
    return project_markers(CAMERA, edges.reshape(len(LAYOUT), -1, 3)).centres


def fitter(twin: Twin) -> PoseFitter:
    rest, tolerance = shot(EDGES), ToleranceSpec()
    return PoseFitter(
        build_unit_model(
            twin, LAYOUT, infer_from_rest(twin, LAYOUT, CameraSpec(), rest, tolerance, NOISE), tolerance
        ),
        NOISE,
    )


def read(reader: PoseFitter, seen: Press, image: int) -> tuple[PoseFit, float, float]:
    """The fit of an image, and what it is off in degrees and mm."""
    found = reader.fit(shot(seen.positions(EDGES)[image]))
    pose = (*seen.obstacle.pose_space.cartesian(seen.obstacle.radial, seen.obstacle.turn_deg), seen.depth[image])
    off = np.abs(found.pose - pose)
    return found, float(off[:2].max()), float(off[2])


def test_the_other_state_begins_where_it_stands_under_all_tilts(twin: Twin) -> None:
    assert twin.inverted is not None
    assert 2.6 < twin.inverted.depths_mm[0] <= 3.0
    assert twin.inverted.depths_mm[-1] == pytest.approx(DEPTH)


def test_an_inverted_skin_is_read_and_said_to_be_one(twin: Twin, other: Press) -> None:
    reader = fitter(twin)
    for image in (-1, -2):
        found, angle, depth = read(reader, other, image)
        assert found.inverted
        assert angle < 0.15
        assert depth < 0.03
        assert found.force.normal_force.value == pytest.approx(np.linalg.norm(other.force[image]), rel=0.02)
        assert found.inverse_friction.half_width > 0.5  # every friction shows alike


def test_without_the_other_state_it_is_a_misfit(twin: Twin, other: Press) -> None:
    """The control: the same images, read by a twin that knows the flat state alone."""
    found, angle, _ = read(fitter(replace(twin, inverted=None)), other, -1)
    assert not found.inverted
    assert found.misfit > 20.0
    assert angle > 1.0


def test_a_skin_that_comes_back_is_read_as_flat_again(twin: Twin, other: Press) -> None:
    reader, pressed = fitter(twin), press(6.0, Branch.FLAT)
    assert not read(reader, pressed, -1)[0].inverted
    assert read(reader, other, -1)[0].inverted
    found, angle, depth = read(reader, pressed, -1)
    assert not found.inverted
    assert angle < 0.15
    assert depth < 0.03


def test_a_picture_in_which_the_skin_has_popped_is_named_anew(twin: Twin, other: Press) -> None:
    """From rest to the inverted state at once: dots beside the ridge change places, until the fit foresees them."""
    scene = SimulatedUnit(Design.of_skin(DOME, LAYOUT, CameraSpec()), Deviation(), RenderSpec())
    sensor = open_sensor([scene.render_rest()], Unit(Design.of_skin(DOME, LAYOUT, CameraSpec())), twin)
    picture = list(scene.render_press(other))[-1]
    by_motion_alone = Tracker(MotionModel(sensor.assignment.positions_px)).step(
        sensor.detector.find(picture).positions_px
    )
    assert by_motion_alone.jumped
    reading = sensor.read(picture)
    assert reading.flags == ()
    assert reading.fit is not None
    assert reading.fit.inverted
    pose = (*other.obstacle.pose_space.cartesian(other.obstacle.radial, other.obstacle.turn_deg), DEPTH)
    assert reading.pose == pytest.approx(pose, abs=0.1)


def test_both_states_survive_the_file(twin: Twin, tmp_path) -> None:
    write_twin(tmp_path / "dome.h5", twin)
    again = read_twin(tmp_path / "dome.h5").inverted
    pose = np.array([3.0, -2.0, 4.5])
    assert again.with_markers(LAYOUT.positions).evaluate(pose, 0.0).positions == pytest.approx(
        twin.inverted.with_markers(LAYOUT.positions).evaluate(pose, 0.0).positions, abs=1e-12
    )


def test_a_skin_without_another_state_has_a_twin_of_one(flat: list[Press]) -> None:
    """The search says "none" as it does for a thick dome, where it ends at rest."""
    wall = WallSpec(depth=0.8, depth_step=0.2)
    none = solve_press(
        mesh_skin(DOME, MeshSpec(cells=10)), ECOFLEX, wall, SolverSpec(derivatives=TWIN_DERIVATIVES), Branch.INVERTED
    )
    assert build_twin(flat, [none]).inverted is None
