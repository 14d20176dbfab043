"""Meshes of barrels: volume by Pappus, faces, clamps, and points found again."""

from collections import Counter

import numpy as np
import pytest
from scipy.integrate import quad

from errors import refused
from palpate.design.barrel import BarrelSpec
from palpate.fea.side_wall import SideWallSpec
from palpate.mesh import Mesh, MeshSpec, centre_mesh, locate_inner, measure_quality, mesh_skin, reshape_mesh

SKIN = BarrelSpec().build()
LOCAL = np.array([[i, j, k] for k in range(3) for j in range(3) for i in range(3)])
"""Places of the 27 nodes of a cell."""


def touched(whole: bool = False, tilt_deg: float = 93.0, **numbers: int) -> Mesh:
    mesh = mesh_skin(SKIN, MeshSpec(whole=whole, **numbers))
    return centre_mesh(
        mesh, SideWallSpec(tilt_deg=tilt_deg, azimuth_deg=40.0 if whole else 0.0).at_first_contact(mesh)[1]
    )


def volume() -> float:
    """By Pappus' theorem: half the difference of the squared radii of the outer and the inner arc, turned around."""

    def section(reach: float) -> float:
        def moment(z: float) -> float:
            return 0.5 * (np.sqrt(reach**2 - (z - SKIN.height / 2) ** 2) - SKIN.centre_radius) ** 2

        return float(quad(moment, 0.0, SKIN.height)[0])

    return 2 * np.pi * (section(SKIN.arc_radius + SKIN.thickness) - section(SKIN.arc_radius))


@pytest.mark.parametrize(
    "mesh",
    [
        mesh_skin(SKIN),
        touched(),
        touched(whole=True),
        touched(tilt_deg=86.0, layers=2),
        mesh_skin(SKIN, MeshSpec(), np.array([0.0, 0.6])),
    ],
)
def test_the_volume_is_that_of_pappus(mesh: Mesh) -> None:
    quality = measure_quality(mesh)
    share = 1.0 if mesh.spec.whole else 0.5
    assert quality.volume == pytest.approx(share * volume(), rel=2e-4)
    assert quality.least_scaled_jacobian > 0.5


@pytest.mark.parametrize("whole", [False, True])
def test_every_face_is_shared_by_two_cells_or_lies_on_a_surface_a_clamp_or_the_mirror(whole: bool) -> None:
    mesh = touched(whole=whole, layers=2)
    sides = [LOCAL[:, axis] == end for axis in range(3) for end in (0, 2)]
    faces = [tuple(sorted(cell[side])) for cell in mesh.cells for side in sides]
    counts = Counter(faces)
    assert set(counts.values()) == {1, 2}
    assert all(len(set(face)) == 9 for face in counts)
    outside = {face for face, count in counts.items() if count == 1}
    surfaces = {tuple(sorted(face)) for face in (*mesh.inner_faces, *mesh.outer_faces)}
    assert surfaces < outside
    base, mirror = set(mesh.base), set(mesh.mirror)
    rest = outside - surfaces
    assert all(set(face) <= base or set(face) <= mirror for face in rest)
    around = 2 * 4 * 3 if whole else 4 * 3
    assert sum(set(face) <= base for face in rest) == 2 * around * mesh.spec.layers


def test_both_ends_are_clamped_and_lie_in_their_planes() -> None:
    mesh = touched()
    ends = mesh.nodes[mesh.base, 2]
    assert np.minimum(abs(ends), abs(ends - SKIN.height)) == pytest.approx(0.0, abs=1e-9)
    assert (ends > 1).sum() == (ends < 1).sum() == len(ends) / 2
    assert set(np.flatnonzero((mesh.nodes[:, 2] < 1e-9) | (mesh.nodes[:, 2] > SKIN.height - 1e-9))) == set(mesh.base)
    assert set(np.flatnonzero(mesh.nodes[:, 0] == 0.0)) == set(mesh.mirror)


def test_cells_are_finest_where_the_wall_touches() -> None:
    mesh = touched(tilt_deg=93.0)
    middles = mesh.nodes[mesh.outer_faces[:, 4]]
    size = np.linalg.norm(mesh.nodes[mesh.outer_faces[:, 0]] - mesh.nodes[mesh.outer_faces[:, 8]], axis=1)
    touch = SKIN.support_point(np.array([0.0, -np.cos(np.radians(3)), -np.sin(np.radians(3))]))
    near = np.linalg.norm(middles - touch, axis=1) < 25
    assert size[near].max() < 0.6 * np.median(size)
    assert np.linalg.norm(mesh.nodes[mesh.pole_outer] - touch) < 5


@pytest.mark.parametrize("whole", [False, True])
def test_points_are_found_by_a_field_that_is_linear_along_and_around(whole: bool) -> None:
    mesh = touched(whole=whole)
    rng = np.random.default_rng(0)
    angle, radius = rng.uniform(-np.pi / 2, np.pi * (1.5 if whole else 0.5), 400), rng.uniform(SKIN.hole, 1.0, 400)
    disc = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    found = locate_inner(mesh, SKIN.marked(disc))
    assert found.interpolate(np.hypot(*mesh.inner_disc.T)[:, None])[:, 0] == pytest.approx(radius, abs=1e-9)
    around = np.arctan2(mesh.inner_disc[:, 1], mesh.inner_disc[:, 0])[found.nodes]
    around = around[:, :1] + (around - around[:, :1] + np.pi) % (2 * np.pi) - np.pi
    error = (found.weights * around).sum(axis=1) - angle
    assert (error + np.pi) % (2 * np.pi) - np.pi == pytest.approx(0.0, abs=1e-9)
    with refused("point-off-surface"):
        locate_inner(mesh, np.array([[0.0, 0.0, 260.0]]))


def test_a_mesh_is_carried_to_a_thicker_barrel_and_one_with_a_gel_is_refused() -> None:
    thicker = BarrelSpec(thickness=4).build()
    mesh = reshape_mesh(touched(), thicker)
    assert measure_quality(mesh).volume > 1.15 * measure_quality(touched()).volume
    with refused("filling-needs-apex"):
        mesh_skin(SKIN, MeshSpec(filled=True))
