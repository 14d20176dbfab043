"""Interpolation of presses of a pad: against a made-up press in closed form, and against presses themselves."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from errors import refused
from palpate.camera import build_camera
from palpate.datasets import generate_dataset
from palpate.design import (
    OFFSET_SPACE,
    TILT_SPACE,
    MarkerSpec,
    Symmetry,
    place_markers,
    rotation_vector,
    wall_normal,
)
from palpate.design.flat_pad import FlatPadSpec
from palpate.fea import WallSpec
from palpate.mechanics import EndReason
from palpate.mesh import MeshSpec, mesh_skin
from palpate.study.study import MaterialSpec
from palpate.surrogate import PressField, build_field
from palpate.surrogate.two_mirror_field import between_azimuths
from presses import build_twin, solve_press

SIZES = {"height": 3.5, "base_radius": 10.4, "thickness": 0.5, "flat_radius": 7.5, "edge_radius": 2.0}
PAD = FlatPadSpec(**SIZES, stretch=1.2, squareness=6.0).build()
LAYOUT = place_markers(PAD, MarkerSpec(ring_diameters=(5.0, 10.0)))
STEP, DEPTH = 0.1, 1.0


def moved_by(points: np.ndarray, tilt_deg: float, azimuth_deg: float, depth: float) -> np.ndarray:
    """Displacement (m, 3) of points under a wall: alike in both mirrors, and smooth in where the wall is."""
    normal = wall_normal(*rotation_vector(np.radians(tilt_deg), np.radians(azimuth_deg)))
    wall = PAD.support_height(normal[None])[0] - depth
    x, y = points[:, 0] / 10, points[:, 1] / 10
    deep = PAD.outer_height - wall + 10 * (x * normal[0] + y * normal[1]) / normal[2]
    across = 0.1 * x * deep * (1 + y**2) + 0.3 * normal[0] * deep
    along = 0.05 * y * deep + 0.2 * normal[1] * deep**2 * (1 + x**2)
    return np.column_stack([across, along, -0.4 * deep])


@dataclass
class PadPress:
    tilt_deg: float
    azimuth_deg: float = 0.0
    reached: float = DEPTH
    symmetry: Symmetry = Symmetry.MIRRORED
    ended: EndReason = EndReason.DEPTH_REACHED
    depth: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.depth = STEP * np.arange(round(self.reached / STEP) + 1)
        self.branch = np.full(len(self.depth), "flat")
        self.ended_depth, self.derivatives = self.reached, {}
        skin = PAD if self.symmetry is Symmetry.MIRRORED else SimpleNamespace(name="odd", symmetry=self.symmetry)
        self.mesh = SimpleNamespace(skin=skin)
        self.obstacle = SimpleNamespace(
            radial=self.tilt_deg,
            turn_deg=self.azimuth_deg,
            depth_step=STEP,
            depth=DEPTH,
            pose_space=TILT_SPACE,
            centred=True,
        )

    def displacement_at(self, points: np.ndarray, by: str = "") -> np.ndarray:
        return np.stack([moved_by(points, self.tilt_deg, self.azimuth_deg, depth) for depth in self.depth])


def pressed(azimuths: Sequence[float] = (0, 30, 60, 90), tilts: Sequence[float] = (1, 2, 3)) -> list[PadPress]:
    return [PadPress(0.0), *(PadPress(float(t), float(a)) for t in tilts for a in azimuths)]


def off_um(found: PressField, tilt_deg: float, azimuth_deg: float, image: int) -> float:
    """Greatest error of the markers, µm."""
    rx, ry = rotation_vector(tilt_deg, np.radians([azimuth_deg])).T
    right = LAYOUT.positions + moved_by(LAYOUT.positions, tilt_deg, azimuth_deg, found.depths_mm[image])
    return 1e3 * float(np.abs(found.positions(rx, ry, image)[0] - right).max())


@pytest.mark.parametrize("azimuth", [0.0, 45.0, 75.0, 90.0, 123.0, 210.0, 300.0, 359.0])
def test_all_azimuths_follow_from_those_of_a_quarter(azimuth: float) -> None:
    found = build_field(pressed(), LAYOUT)
    for tilt in (0.0, 1.0, 2.0, 2.6):
        assert off_um(found, tilt, azimuth, 5) < 2.0


def test_at_the_presses_the_markers_are_theirs() -> None:
    found = build_field(pressed(), LAYOUT)
    for azimuth in (0, 30, 60, 90, 150, 240, 330):
        assert off_um(found, 2.0, azimuth, 6) < 0.05


def test_images_end_where_the_deepest_azimuth_would_need_more() -> None:
    found = build_field(pressed(), LAYOUT)
    last = len(found.depths_mm) - 1
    branch, reason = found.labels(np.array([0.0, 0.5, 3.0]), last)
    assert branch.tolist() == ["flat", "", ""]
    assert reason[2] == "not pressed so deep at every azimuth"
    assert np.isnan(found.positions(np.array([3.0]), np.array([0.0]), last)).all()
    assert found.labels(np.array([3.0]), last - 4)[0].tolist() == ["flat"]
    assert found.labels(np.array([3.5]), 2)[1].tolist() == ["beyond the solved tilts"]


def test_shares_of_azimuths_meet_waves_and_add_up() -> None:
    azimuth, nodes = np.radians([3.0, 77.0, 200.0]), 2 * np.pi * np.arange(12) / 12
    shares = between_azimuths(azimuth, 12)
    assert shares.sum(axis=1) == pytest.approx(1.0)
    for k in range(6):
        assert shares @ np.cos(k * nodes + 0.3) == pytest.approx(np.cos(k * azimuth + 0.3))


@pytest.mark.parametrize(
    ("presses", "says"),
    [
        (pressed((0,)), ("azimuths-incomplete", "0", "30", "60", "90")),
        (pressed((0, 30, 90)), ("azimuths-incomplete", "0", "30", "90")),
        ([*pressed(), PadPress(1.0, 30.0)], ("tilt-twice", "1", "30")),
        ([*pressed(), PadPress(2.5, 30.0)], ("presses-missing", "2.5", "0", "60", "90")),
        ([PadPress(0.0, symmetry=Symmetry.NONE)], ("skin-no-symmetry", "odd")),
    ],
)
def test_presses_that_do_not_serve_every_azimuth_are_refused(presses: list[PadPress], says: tuple[str, ...]) -> None:
    with refused(*says):
        build_field(presses, LAYOUT)


def test_presses_by_other_than_walls_and_forces_of_a_dataset_are_refused() -> None:
    with refused("forces-need-revolution"):
        generate_dataset(pressed(), LAYOUT, build_camera(), forces=True)
    ball = PadPress(0.0)
    ball.obstacle.pose_space = OFFSET_SPACE
    with refused("azimuths-need-flat-wall"):
        build_field([ball], LAYOUT)


@pytest.mark.slow
def test_a_mirrored_press_is_the_press_of_the_mirrored_wall_and_half_a_press_the_whole() -> None:
    material = MaterialSpec(name="neo-hooke:0.1", gel="neo-hooke:0.03").material()

    def press(azimuth: float, *, whole: bool = True) -> object:
        mesh = mesh_skin(PAD, MeshSpec(filled=True, cells=6, core=1, whole=whole))
        return solve_press(mesh, material, WallSpec(tilt_deg=2, azimuth_deg=azimuth, depth=0.3, depth_step=0.1))

    here, there, points = press(30.0), press(150.0), LAYOUT.positions
    mirrored = here.displacement_at(points * [1, -1, 1]) * [1, -1, 1]
    assert mirrored == pytest.approx(there.displacement_at(points), abs=2e-4)
    assert here.force * [1, -1, 1] == pytest.approx(there.force, abs=2e-3 * np.abs(here.force).max())
    assert press(0.0, whole=False).displacement_at(points) == pytest.approx(
        press(0.0).displacement_at(points), abs=5e-4
    )
    with refused("mesh-whole-needed", "30"):
        press(30.0, whole=False)
    with refused("derivative-missing"):
        build_twin([here])
