"""The mesh has the dome's volume, its sets lie where they should, and any point of its surface is found."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from errors import refused
from palpate.design import Dome, DomeSpec, Rim, build_skin, rotation_vector, wall_normal
from palpate.mesh import MeshSpec, centre_mesh, locate_inner, locate_nodes, measure_quality, mesh_skin

domes = st.builds(
    lambda height, base, thickness: build_skin(DomeSpec(height=height, base_radius=base, thickness=thickness)),
    st.floats(8, 32),
    st.floats(12, 25),
    st.floats(0.5, 6),
)


def shell_volume(dome: Dome) -> float:
    """Volume of the region between the two spheres above z = 0, mm³."""

    def cap(radius: float, height: float) -> float:
        return np.pi * height**2 * (3 * radius - height) / 3

    return cap(dome.outer_radius, dome.height + dome.thickness) - cap(dome.radius, dome.height)


def random_surface_points(dome: Dome, count: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    lowest = (dome.radius - dome.height) / dome.radius
    cos = rng.uniform(lowest, 1, count)
    sin, azimuth = np.sqrt(1 - cos**2), rng.uniform(-np.pi / 2, np.pi / 2, count)
    unit = np.stack([sin * np.cos(azimuth), sin * np.sin(azimuth), cos], axis=-1)
    return dome.radius * unit + [0, 0, dome.center_z]


@settings(max_examples=25, deadline=None)
@given(domes)
def test_half_mesh_has_half_the_volume_of_the_dome(dome: Dome) -> None:
    quality = measure_quality(mesh_skin(dome))
    assert quality.volume == pytest.approx(shell_volume(dome) / 2, rel=2e-4)
    # over the whole domain the least is 0.27, of a wall half as thick as its base is wide (H 8, R 12, T 6)
    assert quality.least_scaled_jacobian > (0.3 if dome.thickness <= dome.base_radius / 3 else 0.25)


def test_volume_converges_at_fourth_order() -> None:
    dome = build_skin(DomeSpec(height=20, thickness=2))
    exact = shell_volume(dome) / 2
    specs = [MeshSpec(cells=8 * k, core=k) for k in (1, 2)]
    errors = [abs(measure_quality(mesh_skin(dome, spec)).volume - exact) for spec in specs]
    assert np.log2(errors[0] / errors[1]) > 3.5


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("height", [10, 20, 30])
def test_sets_lie_on_base_mirror_and_apex(height: float, whole: bool) -> None:
    dome = build_skin(DomeSpec(height=height, thickness=2))
    mesh = mesh_skin(dome, MeshSpec(whole=whole))
    assert np.abs(mesh.nodes[mesh.base, 2]).max() < 1e-9
    assert (len(mesh.mirror) == 0) == whole
    assert np.abs(mesh.nodes[mesh.mirror, 0]).max(initial=0) == 0
    assert mesh.nodes[mesh.pole_inner] == pytest.approx([0, 0, dome.height])
    assert mesh.nodes[mesh.pole_outer] == pytest.approx([0, 0, dome.height + dome.thickness])
    reach = np.linalg.norm(mesh.nodes[mesh.outer_faces] - [0, 0, dome.center_z], axis=-1)
    assert reach == pytest.approx(dome.outer_radius)


def test_radial_rim_is_cut_towards_the_centre() -> None:
    dome = build_skin(DomeSpec(height=10, thickness=4))
    mesh = mesh_skin(dome, MeshSpec(rim=Rim.RADIAL))
    arm = mesh.nodes[mesh.base] - [0, 0, dome.center_z]
    polar = np.arccos(arm[:, 2] / np.linalg.norm(arm, axis=1))
    assert np.ptp(polar) < 1e-9


@settings(max_examples=20, deadline=None)
@given(domes, st.integers(0, 1000))
def test_any_surface_point_is_located(dome: Dome, seed: int) -> None:
    mesh = mesh_skin(dome)
    points = random_surface_points(dome, 200, seed)
    found = locate_inner(mesh, points)
    assert found.weights.sum(axis=1) == pytest.approx(1)
    assert np.abs(found.interpolate(mesh.nodes) - points).max() < 2e-3 * dome.radius


def test_interpolation_of_a_quadratic_field_is_nearly_exact() -> None:
    dome = build_skin(DomeSpec())
    points = random_surface_points(dome, 300)

    def field(x: np.ndarray) -> np.ndarray:
        return np.stack([x[..., 0] * x[..., 1], x[..., 2] ** 2, x[..., 0] - x[..., 2]], -1)

    errors = []
    for fineness in (1, 2):
        mesh = mesh_skin(dome, MeshSpec(cells=10 * fineness, core=fineness))
        errors.append(np.abs(locate_inner(mesh, points).interpolate(field(mesh.nodes)) - field(points)).max())
    assert np.log2(errors[0] / errors[1]) > 2.5


@pytest.mark.parametrize("point", [[0, 0, 19], [0, 0, 21], [0, 21, -1]])
def test_a_point_off_the_inner_surface_is_refused(point: list[float]) -> None:
    mesh = mesh_skin(build_skin(DomeSpec()))
    with refused("point-off-surface", "mm"):
        locate_inner(mesh, np.array([point], float))


def test_a_field_moved_to_a_mesh_with_another_pole_keeps_its_values() -> None:
    dome = build_skin(DomeSpec())
    here = mesh_skin(dome, MeshSpec(cells=24, core=2))
    touched = dome.support_point(wall_normal(*rotation_vector(np.radians(10), 0.0)))
    there = centre_mesh(here, touched)
    assert there.nodes[there.pole_outer] == pytest.approx(touched, abs=0.01)
    moved = locate_nodes(there, here).interpolate(there.nodes)
    assert np.abs(moved - here.nodes).max() < 0.02
