"""Solids of the CAD kernel: volumes in closed form, meshes, files."""

import numpy as np
import pytest
from scipy.special import gamma

from errors import refused
from needs import needs
from palpate.design import (
    CadSolid,
    ConeSpec,
    DomeSpec,
    MountSpec,
    SurfaceMesh,
    box,
    build_contact_module,
    build_skin,
    cylinder,
    extrude,
    gather,
    revolve,
    write_step,
)
from palpate.design.solid import loft, read_step
from palpate.design.superellipse import Superellipse

needs("build123d")


@pytest.mark.parametrize(("height", "thickness"), [(10, 1), (20, 2), (30, 4)])
def test_build_solid_has_the_volume_of_a_dome_and_a_drafted_ring(height: float, thickness: float) -> None:
    dome, mount = build_skin(DomeSpec(height=height, thickness=thickness)), MountSpec()
    module = build_contact_module(dome, mount)

    def cap(radius: float) -> float:
        up = dome.center_z + radius  # height of the part above the base plane
        return np.pi * up**2 * (3 * radius - up) / 3

    def frustum(a: float, b: float) -> float:
        return np.pi * mount.flange_thickness * (a * a + a * b + b * b) / 3

    expected = cap(dome.outer_radius) - cap(dome.radius)
    expected += frustum(module.flange_radius, module.flange_foot) - frustum(
        module.opening_radius, module.opening_foot
    )
    assert module.solid().volume == pytest.approx(expected, rel=1e-6)


def test_a_mesh_is_closed_faces_outward_and_keeps_the_volume() -> None:
    solid = build_contact_module(build_skin(DomeSpec()), MountSpec()).solid()
    mesh = solid.mesh()
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(solid.volume, rel=5e-3)
    inside_out = SurfaceMesh(mesh.points, mesh.triangles[:, ::-1])
    assert inside_out.volume == pytest.approx(-mesh.volume)
    assert not SurfaceMesh(mesh.points, mesh.triangles[1:]).is_watertight


def test_welding_merges_points_and_drops_triangles_without_area() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1 + 1e-9]], float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 4], [2, 0, 3], [2, 3, 4]])
    mesh = SurfaceMesh(points, faces)
    assert not mesh.is_watertight
    assert mesh.welded().is_watertight
    assert mesh.welded().volume == pytest.approx(1 / 6)


def test_joining_cutting_and_sharing_add_up() -> None:
    plate, pin = box((0, 0, 0), (10, 10, 2)), cylinder(1.0, -1.0, 3.0, (5.0, 5.0))
    shared = plate.overlap(pin)
    assert shared == pytest.approx(2 * np.pi)
    assert plate.cut(pin).volume == pytest.approx(200 - shared)
    assert plate.join(pin).volume == pytest.approx(200 + 4 * np.pi - shared)
    assert plate.common(pin).volume == pytest.approx(shared)
    assert plate.distance(pin.moved(z=10.0)) == pytest.approx(7.0)
    assert plate.pieces == 1


def test_extrude_and_revolve_follow_straight_outlines() -> None:
    assert extrude([(0, 0), (3, 0), (3, 2), (0, 2)], 4.0).volume == pytest.approx(24)
    assert revolve([(1, 0), (2, 0), (2, 1), (1, 1)]).volume == pytest.approx(3 * np.pi)
    turned = extrude([(0, 0), (3, 0), (3, 2), (0, 2)], 4.0).turned("x", 90.0)
    assert turned.bounds == pytest.approx(np.array([[0, -4, 0], [3, 0, 2]]), abs=1e-6)


def test_loft_round_a_circle_is_revolve() -> None:
    cone = ConeSpec(height=3.5, base_radius=12.9, thickness=0.5, flat_radius=10, edge_radius=2)
    outline = build_contact_module(build_skin(cone), MountSpec()).outline()
    lofted, turned = loft(outline, Superellipse(1.0, 2.0).edge), revolve(outline)
    assert lofted.volume == pytest.approx(turned.volume, rel=1e-6)
    assert lofted.bounds == pytest.approx(turned.bounds, abs=1e-3)
    assert lofted.shape.is_valid


@pytest.mark.parametrize(("stretch", "exponent"), [(1.0, 4.0), (1.2, 6.0), (2.5, 10.0), (1.5, 2.5)])
def test_loft_has_the_area_of_its_plan_at_every_height(stretch: float, exponent: float) -> None:
    area = 4 * stretch * gamma(1 + 1 / exponent) ** 2 / gamma(1 + 2 / exponent)
    body = loft([(0, 0), (3, 0), (2, 4), (0, 4)], Superellipse(stretch, exponent).edge)
    assert body.volume == pytest.approx(area * 4 * (9 + 6 + 4) / 3, rel=2e-6)
    mesh = body.mesh()
    assert mesh.volume == pytest.approx(body.volume, rel=2e-3)


def test_an_outline_that_leaves_the_axis_aslant_is_not_lofted() -> None:
    with refused("outline-leaves-axis-aslant"):
        loft([(0, 1), (1, 0), (0, 0)], Superellipse(1.2, 6.0).edge)


def test_step_keeps_names_and_volumes(tmp_path) -> None:
    parts: dict[str, CadSolid] = {"pin": cylinder(1.0, 0.0, 3.0), "plate": box((0, 0, -1), (4, 4, 0))}
    write_step(tmp_path / "parts.step", "assembly", parts)
    again = read_step(tmp_path / "parts.step")
    assert {name: part.volume for name, part in again.items()} == pytest.approx(
        {name: part.volume for name, part in parts.items()}
    )


def test_the_lines_seen_of_a_cylinder_lie_within_its_silhouette() -> None:
    lines = cylinder(2.0, -3.0, 3.0).look((1000.0, 0.0, 0.0))
    points = np.concatenate(lines)
    assert np.ptp(points[:, 0]) == pytest.approx(4.0, abs=1e-3)
    assert np.ptp(points[:, 1]) == pytest.approx(6.0, abs=1e-3)


def test_gather_keeps_every_body_as_it_is() -> None:
    both = gather([box((0, 0, 0), (1, 1, 1)), cylinder(1.0, 0.0, 1.0, (5.0, 0.0))])
    assert both.pieces == 2
    assert both.volume == pytest.approx(1 + np.pi)


def test_two_bodies_apart_have_nothing_in_common() -> None:
    with refused("solids-not-joined", "0"):
        box((0, 0, 0), (1, 1, 1)).common(box((2, 2, 2), (3, 3, 3)))


def test_a_meridian_lies_on_the_sphere_and_ends_on_base_or_axis() -> None:
    dome = build_skin(DomeSpec(height=30, thickness=2))
    (down,), (back,) = (dome.meridian(dome.thickness, down=way) for way in (True, False))
    for x, z in (down.through, down.end, back.end):
        assert np.hypot(x, z - dome.center_z) == pytest.approx(dome.outer_radius)
    assert down.end == pytest.approx((dome.outer_base_radius, 0.0), abs=1e-9)
    assert back.end == pytest.approx((0.0, 32.0))
    assert down.through == back.through
