"""Body, mold, window and pack of a flat pad, which is carried round a superellipse instead of turned."""

import json
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import gamma
from step_files import read_parts
from stored_pack import stored_pack

from errors import check_values, refused
from needs import needs
from palpate.camera import CameraSpec, WindowSpec
from palpate.design import (
    ContactModule,
    Design,
    MarkerSpec,
    MountSpec,
    Rim,
    SurfaceMesh,
    build_contact_module,
    rotation_vector,
    wall_normal,
)
from palpate.design.flat_pad import FlatPadSpec
from palpate.fabrication import ProcessSpec, build_mold, write_pack
from palpate.fabrication.enclosure import Enclosure, free_travel
from palpate.fabrication.flange_key import build_notch
from palpate.fabrication.window_plate import build_window
from palpate.material import get_material

needs("build123d")
SPEC = FlatPadSpec(height=3.5, base_radius=10.375, thickness=0.5, stretch=1.217, squareness=6.0, flat_radius=7.5)
PAD = SPEC.build()
PROCESS = ProcessSpec(working_depth=1.0, working_tilt_deg=3.0)
AREA = 4 * 1.217 * gamma(1 + 1 / 6) ** 2 / gamma(1 + 2 / 6)
"""Of the plan, for a half width of 1."""


@pytest.fixture(scope="module")
def module() -> ContactModule:
    return build_contact_module(PAD, MountSpec())


def frustum(low: float, high: float, height: float) -> float:
    return (low * low + low * high + high * high) / 3 * height


def flat_top(offset: float) -> float:
    """Volume over the base and under the surface `offset` mm outside the inner one, over the area of the plan."""
    cone = PAD.cone
    edge, theta = cone.edge_radius + offset, cone.flank_slope
    round_part = quad(lambda a: (cone.flat_radius + edge * np.sin(a)) ** 2 * edge * np.sin(a), 0, theta)[0]
    end = cone.flat_radius + edge * np.sin(theta)
    foot = cone.base_radius + offset / np.sin(theta)
    return round_part + frustum(end, foot, cone.height + offset - edge * (1 - np.cos(theta)))


def body_mm3(module: ContactModule) -> float:
    """Volume of the module, by integrals over its height."""
    ring = frustum(module.flange_radius, module.flange_foot, 3.0) - frustum(
        module.opening_radius, module.opening_foot, 3.0
    )
    return AREA * (flat_top(0.5) - flat_top(0.0) + ring)


def test_a_pads_module_has_the_volume_of_its_sections_and_not_that_of_a_round_one(module: ContactModule) -> None:
    volume = module.solid().volume
    assert volume == pytest.approx(body_mm3(module), rel=2e-6)
    turned = build_contact_module(PAD.cone, MountSpec()).solid().volume
    assert turned == pytest.approx(body_mm3(module) * np.pi / AREA, rel=1e-6)
    assert turned < 0.7 * volume


def off_surface(points: np.ndarray) -> np.ndarray:
    """Distance (n,) mm of points (n, 3) above the base from the nearer one of the pad's two surfaces."""
    disc = PAD.disc(points)
    found = [np.linalg.norm(PAD.point(disc, layer, Rim.RADIAL) - points, axis=1) for layer in (0.0, 1.0)]
    return np.min(found, axis=0)


def test_the_mesh_of_a_pad_is_closed_and_lies_on_its_two_surfaces(module: ContactModule) -> None:
    mesh = module.solid().mesh()
    assert mesh.is_watertight
    above = mesh.points[mesh.points[:, 2] > 1e-6]
    assert len(above) > 500
    assert off_surface(above).max() < 1e-3
    round_one = build_contact_module(PAD.cone, MountSpec()).solid().mesh().points
    assert off_surface(round_one[round_one[:, 2] > 1e-6]).max() > 0.1


def test_mold_and_part_fill_the_block_of_a_pad(module: ContactModule) -> None:
    mold, spec = build_mold(module, PROCESS), PROCESS
    core, cavity = mold.parts["mold_core"], mold.parts["mold_cavity"]
    block = AREA * mold.radius**2 * (spec.plate + module.skin.outer_height + spec.mold_floor + 3.0)
    through = np.pi / 4 * (spec.pour_diameter**2 + spec.vents * spec.vent_diameter**2) * spec.plate
    pin, hole = spec.pin_diameter / 2, spec.pin_diameter / 2 + spec.clearance
    play = 3 * np.pi * (hole**2 * (spec.pin_height + 0.5) - pin**2 * spec.pin_height)
    body = body_mm3(module) - module.solid().overlap(build_notch(module))
    assert core.volume + cavity.volume + through + play + body == pytest.approx(block, rel=2e-6)
    assert mold.hollow() == pytest.approx(body, rel=2e-6)
    assert core.pieces == cavity.pieces == 1


@pytest.mark.slow
def test_a_pads_mold_closes_one_way_only(module: ContactModule) -> None:
    mold = build_mold(module, PROCESS)
    core, cavity = mold.parts["mold_core"], mold.parts["mold_cavity"]
    assert core.overlap(cavity) < 1e-3
    assert core.overlap(cavity.turned("z", 180.0)) > 1.0


def test_a_window_lies_in_the_opening_and_holds_the_gel(module: ContactModule) -> None:
    window = build_window(module, 2.0, PROCESS)
    assert window.gel_mm3 == pytest.approx(AREA * flat_top(0.0), rel=2e-6)
    assert window.solid.volume == pytest.approx(AREA * (10.375 - PROCESS.clearance) ** 2 * 2.0, rel=2e-6)
    assert window.solid.bounds[:, 2] == pytest.approx([-2.0, 0.0], abs=1e-6)
    assert PAD.plan.pseudo_radius(window.line) == pytest.approx(10.225)
    for thickness in (0.0, 3.5):
        with refused("window-too-thick", "3"):
            build_window(module, thickness, PROCESS)


def test_the_ring_stops_the_wall_of_the_worst_azimuth(module: ContactModule) -> None:
    ring = ((18.0, 1.5), (33.0, -1.5))
    tilt = np.radians(3.0)
    outer = PAD.point(np.random.default_rng(0).uniform(-0.7, 0.7, (20000, 2)), 1.0)
    heights = []
    for azimuth in np.linspace(0, np.pi / 2, 31):
        normal = wall_normal(*rotation_vector(tilt, azimuth))
        heights.append((outer @ normal).max() / normal[2])
    expected = min(min(heights) - reach * np.tan(tilt) - z for reach, z in ring)
    assert free_travel(module, Enclosure({}, 30.0, ring, ("", "")), 3.0) == pytest.approx(expected, abs=2e-3)
    assert max(heights) > min(heights) + 0.05


def design_of(camera: CameraSpec) -> Design:
    material = replace(get_material("neo-hooke:0.1"), gel=get_material("neo-hooke:0.03"))
    markers = MarkerSpec(ring_diameters=(4.5, 9.0, 13.5), diameter=0.6)
    return Design(SPEC, markers, camera, material)


@pytest.mark.slow(30)
def test_a_pack_of_a_filled_pad_has_closed_parts_a_window_and_the_gel() -> None:
    pack = stored_pack(design_of(CameraSpec(distance=30, window=WindowSpec())), PROCESS, MountSpec())
    for name, volume in pack.volumes.items():
        mesh = meshio.read(pack.folder / f"{name}.stl")
        points, number = np.unique(mesh.points, axis=0, return_inverse=True)
        found = SurfaceMesh(points.astype(float), number.reshape(-1)[mesh.cells_dict["triangle"]])
        assert found.is_watertight, name
        assert found.volume == pytest.approx(volume, rel=5e-3)
    read_parts(pack)
    assert {"window.dxf", "template.stl"} <= set(pack.files)
    assert {finding.code for finding in pack.findings} == {"elastomer", "vents", "gel"}
    gel = AREA * flat_top(0.0) / 1000
    sheet = (pack.folder / "instructions.md").read_text()
    steps = [line for line in sheet.splitlines() if line.startswith("## ")]
    at = [next(n for n, step in enumerate(steps) if word in step) for word in ("markers", "gel", "Inspect")]
    assert at == sorted(at)
    check_values(sheet, f"{gel:.2f} mL", f"{1.3 * gel:.1f} mL")
    assert json.loads((pack.folder / "manifest.json").read_text())["design"]["gel"] == "neo-hooke:0.03"


def test_a_gel_without_a_window_is_refused(tmp_path: Path) -> None:
    with refused("window-missing"):
        write_pack(tmp_path / "pack", design_of(CameraSpec(distance=30)), PROCESS)
    assert list(tmp_path.iterdir()) == []
