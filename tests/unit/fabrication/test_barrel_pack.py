"""Body, mold, dots, frame and pack of a barrel, which is clamped and has a flange at both ends."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.integrate import quad
from step_files import read_parts
from stored_pack import stored_pack

from errors import check_values, refused
from needs import needs
from palpate.camera import CameraSpec, build_camera
from palpate.design import (
    CadSolid,
    ContactModule,
    Design,
    MarkerLayout,
    MarkerSpec,
    MountSpec,
    box,
    build_contact_module,
    cylinder,
    place_markers,
    place_orientation_mark,
)
from palpate.design.barrel import BarrelSpec
from palpate.fabrication import ProcessSpec, build_enclosure, build_mold, check_process, write_pack
from palpate.fabrication.check_parts import check_enclosure, check_frame, check_interference
from palpate.fabrication.enclosure import free_travel
from palpate.fabrication.flange_key import build_notch
from palpate.fabrication.frame import ROD, plan_frame
from palpate.fabrication.pins import build_dimples

needs("build123d")
TACLINK = BarrelSpec().build()
MOUNT = MountSpec(flange_width=3.5)
PROCESS = ProcessSpec()
SMALL = BarrelSpec(height=90, base_radius=20, thickness=2.5, middle_radius=26)
ROWS = MarkerSpec(rows=4, around=8, pitch=16, diameter=4)
FISHEYE = CameraSpec(
    lens="kannala-brandt", width_px=1280, height_px=960, fx_px=440, fy_px=440, cx_px=639.5, cy_px=479.5, distance=20
)


def small_process(**change: float) -> ProcessSpec:
    return ProcessSpec(pour_diameter=4, working_depth=3, working_tilt_deg=0, **change)


def pack_of(**change: object) -> tuple[Design, ProcessSpec, MountSpec]:
    process, mount = change.pop("process", small_process()), change.pop("mount", MOUNT)
    return replace(Design(SMALL, ROWS, FISHEYE), **change), process, mount


@pytest.fixture(scope="module")
def module() -> ContactModule:
    return build_contact_module(TACLINK, MOUNT)


@pytest.fixture(scope="module")
def layout() -> MarkerLayout:
    return place_markers(TACLINK, MarkerSpec(rows=16, around=16, pitch=15, diameter=6))


def frustum(low: float, high: float, height: float) -> float:
    return np.pi * (low * low + low * high + high * high) / 3 * height


def body_mm3(module: ContactModule) -> float:
    """Volume of the module, by Pappus for the wall: its section lies between two arcs and both ends."""
    skin, half = module.skin, module.skin.height / 2

    def within(reach: float) -> float:
        return quad(lambda z: np.pi * (np.sqrt(reach**2 - z**2) - skin.centre_radius) ** 2, -half, half)[0]

    thick = module.flange_thickness
    ring = frustum(module.flange_radius, module.flange_foot, thick)
    ring -= frustum(module.opening_radius, module.opening_foot, thick)
    return within(skin.arc_radius + skin.thickness) - within(skin.arc_radius) + 2 * ring


def test_a_barrels_module_has_both_flanges_and_the_volume_of_its_section(module: ContactModule) -> None:
    body = module.solid()
    assert body.volume == pytest.approx(body_mm3(module), rel=1e-9)
    assert body.bounds[:, 2] == pytest.approx([-3.0, 263.0], abs=1e-6)
    upside_down = body.turned("x", 180.0).moved(z=260.0)
    assert body.overlap(upside_down) == pytest.approx(body.volume, rel=1e-6)


def test_the_mesh_of_a_barrel_lies_on_both_arcs_also_between_its_points(module: ContactModule) -> None:
    mesh = module.solid().mesh()
    assert mesh.is_watertight
    corners = mesh.points[mesh.triangles]
    wall = corners[(corners[..., 2].min(axis=1) > -1e-6) & (corners[..., 2].max(axis=1) < 260 + 1e-6)]
    away = np.abs(TACLINK.distance(wall)[..., None] - [0.0, TACLINK.thickness])
    side = away.max(axis=1).argmin(axis=1)  # the surface on which all three corners lie
    on_one = away.max(axis=1).min(axis=1) < 1e-4
    assert on_one.sum() > 5000
    middle = TACLINK.distance(wall.mean(axis=1)) - TACLINK.thickness * side
    assert np.abs(middle[on_one]).max() < 0.022


def test_core_halves_and_part_fill_the_block_of_a_barrel(module: ContactModule) -> None:
    spec, mold = PROCESS, build_mold(module, PROCESS)
    assert set(mold.parts) == {"mold_core", "mold_cavity_front", "mold_cavity_back"}
    block = np.pi * mold.radius**2 * (spec.plate + 266.0 + spec.mold_floor)
    through = np.pi / 4 * (spec.pour_diameter**2 + spec.vents * spec.vent_diameter**2) * spec.plate
    pin, hole = spec.pin_diameter / 2, spec.pin_diameter / 2 + spec.clearance
    play = 3 * np.pi * (hole**2 * (spec.pin_height + 0.5) - pin**2 * spec.pin_height)
    play += np.pi * ((mold.spigot + spec.clearance) ** 2 - mold.spigot**2) * spec.mold_floor
    dowels = 4 * np.pi * (1.0 + spec.clearance / 2) ** 2 * 12.0
    parts = sum(part.volume for part in mold.parts.values())
    body = body_mm3(module) - module.solid().overlap(build_notch(module))
    assert parts + through + play + dowels + body == pytest.approx(block, rel=1e-8)
    assert mold.hollow() == pytest.approx(body, rel=1e-9)
    assert all(part.pieces == 1 for part in mold.parts.values())


def test_a_barrels_mold_closes_one_way_only(module: ContactModule) -> None:
    parts = build_mold(module, PROCESS).parts
    core, front, back = parts["mold_core"], parts["mold_cavity_front"], parts["mold_cavity_back"]
    check_interference(parts)
    assert core.overlap(front.moved(y=-30)) == pytest.approx(0.0, abs=1e-3)  # a half leaves the core sideways
    for turn in (90.0, 180.0, 270.0):
        assert core.overlap(front.turned("z", turn)) + core.overlap(back.turned("z", turn)) > 1.0


def test_dimples_are_where_the_dots_are_and_as_deep(layout: MarkerLayout) -> None:
    scale, depth = 1.01, 0.4
    dimples = build_dimples(TACLINK, layout, depth, scale, mark=True)
    points = np.vstack([layout.positions, place_orientation_mark(TACLINK, layout)])
    assert len(dimples) == len(points) == 257
    long = depth + 0.25 * TACLINK.thickness
    middles = np.array([dimple.bounds.mean(axis=0) for dimple in dimples])
    assert middles == pytest.approx(scale * (points + (long / 2 - depth) * TACLINK.normal(points)), abs=1e-5)
    core = build_contact_module(TACLINK, MOUNT, scale)
    plug = core.solid(core.inside())
    across, along = 50.0 / np.cos(np.radians(0.86)), TACLINK.arc_radius
    ball = np.pi * 9 * depth - np.pi * 81 / 8 * (1 / across + 1 / along)  # of a middle row; the core bends away
    assert dimples[7 * 16 + 3].overlap(plug) == pytest.approx(scale**3 * ball, rel=5e-3)
    assert build_dimples(TACLINK, layout, 0.8, scale, mark=True)[100].overlap(plug) > 1.8 * scale**3 * ball


def test_the_mark_of_a_barrel_breaks_the_symmetry_of_its_rows(layout: MarkerLayout) -> None:
    mark = place_orientation_mark(TACLINK, layout)
    assert TACLINK.distance(mark[None]) == pytest.approx(0.0, abs=1e-9)
    assert TACLINK.distance_to_rim(mark[None])[0] > layout.diameter / 2
    assert np.linalg.norm(layout.positions - mark, axis=1).min() > 1.4 * layout.diameter
    step = np.degrees(np.arctan2(mark[1], mark[0])) % 22.5
    assert step == pytest.approx(22.5 / 4)
    near = build_rows(pitch=17.0)
    room = TACLINK.distance_to_rim(np.vstack([near.positions, place_orientation_mark(TACLINK, near)]))
    assert room[-1] == pytest.approx(room[:-1].min() / 2)


def build_rows(pitch: float) -> MarkerLayout:
    return place_markers(TACLINK, MarkerSpec(rows=16, around=16, pitch=pitch, diameter=6))


def test_rods_carry_the_far_end_between_the_columns_of_dots(module: ContactModule, layout: MarkerLayout) -> None:
    frame = plan_frame(module, layout)
    enclosure = build_enclosure(module, 20.0, PROCESS, frame=frame)
    parts, body = enclosure.parts, module.solid().cut(build_notch(module))
    clamped = [frozenset((ring, "module")) for ring in ("clamp_ring", "end_ring")]
    check_interference({**parts, "module": body}, intended=clamped)
    squeezed = np.pi * (module.flange_radius**2 - 37.7**2) * 0.2
    for ring in ("clamp_ring", "end_ring"):
        assert parts[ring].overlap(body) == pytest.approx(squeezed, rel=0.05)
        assert parts[ring].pieces == 2
    assert parts["rods"].volume == pytest.approx(4 * np.pi / 4 * ROD**2 * frame.length, rel=1e-9)
    assert parts["rods"].distance(body) > 2.0
    assert parts["housing"].pieces == parts["end_cap"].pieces == 1
    turned = np.degrees(frame.azimuths) % 22.5
    assert turned == pytest.approx(11.25, abs=1e-3)


def seen_by_boxes(rods: CadSolid, origin: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether a thin cylinder from the pinhole to each point meets a rod: by the CAD kernel."""
    found = []
    for point in points:
        way = point - origin
        length = float(np.linalg.norm(way))
        lean, turn = np.degrees(np.arccos(way[2] / length)), np.degrees(np.arctan2(way[1], way[0]))
        ray = cylinder(1e-3, 0.0, length).turned("y", float(lean)).turned("z", float(turn)).moved(*origin)
        found.append(rods.distance(ray) < 1e-6)
    return np.array(found)


def test_what_rods_hide_is_what_lines_of_sight_meet(module: ContactModule, layout: MarkerLayout) -> None:
    frame = plan_frame(module, layout)
    camera = build_camera(FISHEYE)
    assert list(check_frame(frame, layout, camera)) == []
    turned = replace(frame, azimuths=tuple(azimuth + np.radians(9.0) for azimuth in frame.azimuths))
    rods = build_enclosure(module, 20.0, PROCESS, frame=turned).parts["rods"]
    some = layout.positions[::5]
    hidden = turned.hidden(camera.origin, some)
    assert 0 < hidden.sum() < len(some)
    assert hidden.tolist() == seen_by_boxes(rods, camera.origin, some).tolist()
    (finding,) = check_frame(turned, layout, camera)
    assert finding.code == "marker-behind-rod"


def test_a_wall_at_the_side_is_stopped_by_the_rings_where_geometry_says(
    module: ContactModule, layout: MarkerLayout
) -> None:
    enclosure = build_enclosure(module, 20.0, PROCESS, frame=plan_frame(module, layout))
    ring = enclosure.parts["clamp_ring"].join(enclosure.parts["end_ring"])
    for tilt in (0.0, 2.0):
        travel = free_travel(module, enclosure, tilt)
        wall = box((0, -200, -400), (50, 200, 400)).turned("y", tilt)
        normal = np.array([np.cos(np.radians(tilt)), 0.0, -np.sin(np.radians(tilt))])
        at = TACLINK.support_point(normal) @ normal
        assert ring.overlap(wall.moved(*((at - travel + 0.05) * normal))) < 1e-3
        assert ring.overlap(wall.moved(*((at - travel - 0.2) * normal))) > 1e-3
    deep = ProcessSpec(working_depth=7, working_tilt_deg=5)
    (finding,) = check_enclosure(module, enclosure, deep)
    check_values(finding.message, "0 mm", "7 mm")
    check_values(finding.remedy, 1.5, "258.5 mm")


@pytest.mark.slow
def test_a_pack_of_a_barrel_has_closed_parts_dimples_and_a_sheet() -> None:
    pack = stored_pack(*pack_of())
    for name, volume in pack.volumes.items():
        mesh = trimesh.load(pack.folder / f"{name}.stl")
        assert mesh.is_watertight, name
        assert mesh.volume == pytest.approx(volume, rel=3e-3)
    parts = read_parts(pack)
    assert not {"template.stl", "artwork.dxf"} & set(pack.files)
    assert {"enclosure_section.png", "markers.csv"} <= set(pack.files)
    scale = 1 / (1 - 0.001)
    module = build_contact_module(SMALL.build(), MOUNT, scale)
    bare = build_mold(module, small_process()).parts["mold_core"].volume
    assert bare - parts["mold_core"].volume == pytest.approx(33 * np.pi * 4 * 0.4 * scale**3, rel=0.15)
    check_floors(pack.folder, scale)
    sheet = (pack.folder / "instructions.md").read_text()
    mixed = 1.3 * body_mm3(module) / 1000
    check_values(sheet, f"{mixed:.1f} mL", 1.3)
    assert "artwork.dxf" not in sheet
    assert "All 32 dots and the orientation mark" in sheet, "33 dimples"
    for ring in ("clamp_ring", "end_ring"):
        faces = trimesh.load(pack.folder / f"{ring}.stl")
        bed = faces.area_faces[faces.triangles[..., 2].max(axis=1) < faces.bounds[0, 2] + 1e-3].sum()
        assert bed > 0.2 * faces.area, "its flat face is on the bed"


def check_floors(folder: Path, scale: float) -> None:
    """Every dimple of the printed core ends in a flat circle about its dot, 0.4 mm inward."""
    skin = SMALL.build()
    layout = place_markers(skin, ROWS)
    core = trimesh.load(folder / "mold_core.stl").vertices - [0.0, 0.0, PROCESS.plate + 3.0 * scale]
    points = np.vstack([layout.positions, place_orientation_mark(skin, layout)])
    for point, normal in zip(points, skin.normal(points), strict=True):
        away = core - scale * (point - 0.4 * normal)
        across = np.linalg.norm(away - (away @ normal)[:, None] * normal, axis=1)
        edge = away[(across < 2.05 * scale) & (np.abs(away @ normal) < 2e-4)]
        assert len(edge) > 20
        assert np.linalg.norm(edge, axis=1) == pytest.approx(2.0 * scale, abs=2e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"process": small_process(printer_size=100)}, ("part-too-long", "mold_core", "106.1", "100")),
        ({"skin_spec": SMALL.model_copy(update={"middle_radius": 64.0})}, ("peel-stretch", "3.2", "3")),
        ({"skin_spec": SMALL.model_copy(update={"thickness": 0.25})}, ("wall-uneven", "60", "0.25")),
        ({"skin_spec": SMALL.model_copy(update={"base_radius": 12.0})}, ("frame-no-view",)),
        ({"process": small_process(dot_depth=0.1)}, ("dimple-too-shallow", "0.081", "0.1")),
        ({"markers": ROWS.model_copy(update={"around": 36, "count": 144})}, ("dimples-too-near",)),
    ],
)
def test_a_barrel_that_cannot_be_made_is_refused_and_leaves_nothing(
    change: dict[str, object], message: tuple[str, ...], tmp_path: Path
) -> None:
    with refused(*message):
        write_pack(tmp_path / "pack", *pack_of(**change))
    assert list(tmp_path.iterdir()) == []


def test_the_workshop_hears_of_a_barrels_limits() -> None:
    found = check_process(Design(SMALL.model_copy(update={"thickness": 1.0}), ROWS, FISHEYE), PROCESS)
    assert {finding.code for finding in found} == {"undercut", "peel-stretch", "wall-uneven"}
    assert all(finding.message and finding.remedy for finding in found)
