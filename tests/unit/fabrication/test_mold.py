"""Mold, enclosure and template as solids."""

from pathlib import Path

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.design import (
    ConeSpec,
    DomeSpec,
    EllipsoidSpec,
    MarkerSpec,
    MountSpec,
    SkinSpec,
    SplineSpec,
    box,
    build_contact_module,
    build_skin,
    cylinder,
    place_markers,
)
from palpate.design.flat_pad import FlatPadSpec
from palpate.fabrication import CameraBody, ProcessSpec, build_enclosure, build_mold, build_template, write_mesh
from palpate.fabrication.enclosure import free_travel
from palpate.fabrication.flange_key import build_key, build_notch, notch_radius
from palpate.fabrication.pack_drawings import draw_mold_section

needs("build123d")
SPEC = ProcessSpec()


def module_of(height: float, thickness: float = 2.0):
    return build_contact_module(build_skin(DomeSpec(height=height, thickness=thickness)), MountSpec())


@pytest.mark.parametrize("height", [10, 20, 30])
def test_build_mold_leaves_the_module_between_its_parts(height: float) -> None:
    module = module_of(height)
    mold, body = build_mold(module, SPEC), module.solid().cut(build_notch(module))
    assert mold.hollow() == pytest.approx(body.volume, rel=1e-9)
    for part in mold.parts.values():
        assert part.pieces == 1
        assert body.overlap(part) == pytest.approx(0.0, abs=1e-3)
        assert part.mesh().is_watertight
    assert mold.is_split == (height > 20)


@pytest.mark.parametrize(
    "spec",
    [
        ConeSpec(height=20, base_radius=14, flat_radius=5, edge_radius=5),
        ConeSpec(height=26, base_radius=12, edge_radius=12),
        EllipsoidSpec(height=18, taper=1.6),
        SplineSpec(height=16, points=((0.5, 0.92), (0.85, 0.55))),
    ],
    ids=lambda spec: spec.build().name,
)
def test_a_mold_of_any_meridian_leaves_the_module_between_its_parts(spec: SkinSpec) -> None:
    module = build_contact_module(spec.build(), MountSpec())
    mold, body = build_mold(module, SPEC), module.solid().cut(build_notch(module))
    assert mold.hollow() == pytest.approx(body.volume, rel=1e-6)
    for part in mold.parts.values():
        assert part.pieces == 1
        assert body.overlap(part) == pytest.approx(0.0, abs=1e-3)
        assert part.mesh().is_watertight


def test_pins_fit_with_the_clearance_asked_and_one_way_only() -> None:
    mold = build_mold(module_of(20), SPEC)
    core, cavity = mold.parts["mold_core"], mold.parts["mold_cavity"]
    assert core.overlap(cavity) < 1e-3
    assert core.overlap(cavity.moved(x=0.9 * SPEC.clearance)) < 1e-3
    assert core.overlap(cavity.moved(x=1.5 * SPEC.clearance)) > 1e-2
    for turn in (60.0, 110.0, 120.0, 130.0, 180.0, 240.0):
        assert core.overlap(cavity.turned("z", turn)) > 1.0


@pytest.mark.parametrize("spec", [DomeSpec(), DomeSpec(height=30), FlatPadSpec()], ids=lambda one: one.build().name)
def test_the_notch_of_a_flange_fits_rib_and_key_one_way_only(spec: SkinSpec) -> None:
    module = build_contact_module(spec.build(), MountSpec())
    body, radius = module.solid().cut(build_notch(module)), notch_radius(module)
    key = build_key(module, SPEC.clearance)
    assert body.overlap(key) == pytest.approx(0, abs=1e-6)
    assert body.distance(key) == pytest.approx(SPEC.clearance, abs=1e-3)
    half = module.skin.plan.edge(np.radians([270.0]))[0][0][1] * module.flange_foot
    x, y, z = np.array(key.bounds).T
    assert x == pytest.approx([SPEC.clearance - radius, radius - SPEC.clearance], abs=1e-3)
    assert y[1] == pytest.approx(half + radius - SPEC.clearance, abs=1e-3), "opposite the cable slot"
    assert z[1] < 0
    cavity = module.prism(module.flange_foot + 8, module.foot, 0.0).cut(module.solid(module.outside()))
    for part in (key, cavity.join(build_notch(module))):
        for turn in (20.0, 90.0, 180.0, 270.0) if module.skin.plan.is_round else (180.0,):
            assert body.turned("z", turn).overlap(part) > 1.0
        assert body.overlap(part) == pytest.approx(0, abs=1e-3)


def test_housing_and_robot_plate_fit_one_way_only() -> None:
    parts = build_enclosure(module_of(20), 48.0, SPEC).parts
    housing, plate = parts["housing"], parts["robot_plate"]
    low, edge = float(housing.bounds[0, 2]), float(plate.bounds[1, 0])
    holes = cylinder(edge - 1, low - 7, low - 6).cut(cylinder(31.5, low - 7, low - 6), plate)
    threads = cylinder(edge - 1, low + 1, low + 2).cut(cylinder(31.5, low + 1, low + 2), housing).moved(z=-8.0)
    assert threads.cut(holes).volume == pytest.approx(0, abs=1e-6)
    for turn in (80.0, 90.0, 100.0, 180.0, 190.0, 270.0):
        assert threads.turned("z", turn).cut(holes).volume > 1.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pour_diameter": 12}, ("pour-hole-too-wide", "12")),
        ({"pin_diameter": 8}, ("mold-pin-too-thick", "8")),
        ({"pin_height": 6}, ("mold-pin-too-high", "6")),
    ],
)
def test_a_mold_that_cannot_be_is_refused_with_the_number(change: dict[str, float], message: tuple[str, ...]) -> None:
    with refused(*message):
        build_mold(module_of(20), ProcessSpec(**change))


@pytest.mark.parametrize("camera", CameraBody)
def test_build_enclosure_holds_the_module_and_nothing_interferes(camera: CameraBody) -> None:
    module = module_of(20)
    enclosure = build_enclosure(module, 48.0, ProcessSpec(camera_body=camera))
    parts, body = enclosure.parts, module.solid().cut(build_notch(module))
    assert parts["housing"].overlap(body) < 1e-3
    assert parts["housing"].overlap(parts["clamp_ring"]) < 1e-3
    assert parts["housing"].overlap(parts["robot_plate"]) < 1e-3
    squeezed = parts["clamp_ring"].overlap(body)
    assert 0 < squeezed < 0.1 * body.volume
    for part in parts.values():
        assert part.pieces == 1


def test_the_wall_is_stopped_by_the_clamp_ring_where_geometry_says() -> None:
    module = module_of(10)
    enclosure = build_enclosure(module, 48.0, SPEC)
    ring = enclosure.parts["clamp_ring"]
    for tilt in (0.0, 12.0):
        travel = free_travel(module, enclosure, tilt)
        top = module.skin.center_z + module.skin.outer_radius / np.cos(np.radians(tilt))
        wall = box((-200, -200, 0), (200, 200, 50)).turned("x", tilt)  # falls along y
        assert ring.overlap(wall.moved(z=top - travel + 0.05)) < 1e-3
        assert ring.overlap(wall.moved(z=top - travel - 0.2)) > 1e-3
    assert free_travel(module, enclosure, 12.0) < 8.0 < free_travel(module_of(20), enclosure, 12.0)


def test_a_camera_in_the_light_is_refused() -> None:
    with refused("camera-no-room", "8"):
        build_enclosure(module_of(20), 8.0, SPEC)


def test_build_template_has_a_hole_at_every_marker() -> None:
    dome = build_skin(DomeSpec(height=20))
    layout = place_markers(dome, MarkerSpec(count=37))
    mesh = build_template(dome, layout, SPEC)
    assert mesh.is_watertight
    edges = len(
        np.unique(np.sort(np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1), axis=0)
    )
    euler = len(mesh.points) - edges + len(mesh.triangles)
    assert euler == 2 - 2 * 38  # a shell with a hole through it at each of 37 markers and at the mark


@pytest.mark.parametrize(
    ("height", "count", "diameter", "message"),
    [(30, 37, 1.5, ("template-too-wide",)), (20, 169, 2.4, ("template-holes-too-near",))],
)
def test_a_template_that_cannot_be_is_refused(
    height: float, count: int, diameter: float, message: tuple[str, ...]
) -> None:
    dome = build_skin(DomeSpec(height=height))
    with refused(*message):
        build_template(dome, place_markers(dome, MarkerSpec(count=count, diameter=diameter)), SPEC)


@pytest.mark.parametrize("suffix", ["stl", "3mf"])
def test_a_written_mesh_of_another_volume_than_its_solid_is_reported(suffix: str, tmp_path: Path) -> None:
    solid = box((0.0, 0.0, 0.0), (10.0, 10.0, 10.0))
    write_mesh(tmp_path / f"whole.{suffix}", solid.mesh(), solid.volume)
    write_mesh(tmp_path / f"near.{suffix}", solid.mesh(), 1.004 * solid.volume)
    with refused("mesh-file-volume", 1000, 1006):
        write_mesh(tmp_path / f"far.{suffix}", solid.mesh(), 1.006 * solid.volume)


def test_sizes_on_the_drawing_are_those_of_the_parts() -> None:
    mold = build_mold(module_of(20), SPEC)
    figure = draw_mold_section(mold, SPEC)
    texts = [text.get_text().removeprefix("core ") for text in figure.axes[0].texts]
    drawn = [float(text) for text in texts if text.replace(".", "").isdigit()]
    cavity, core = (np.ptp(mold.parts[name].bounds, axis=0) for name in ("mold_cavity", "mold_core"))
    for size in (cavity[0], cavity[2] - SPEC.pin_height, core[2] - SPEC.plate):  # without its pins
        assert np.abs(np.array(drawn) - size).min() < 0.02, (size, drawn)
