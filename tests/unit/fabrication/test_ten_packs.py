"""Packs of ten designs and four kinds of skins: overlaps, impossible steps, numbers that differ from the parts."""

import csv
import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import meshio
import numpy as np
import pytest
from step_files import read_parts
from stored_pack import stored_pack

from needs import needs
from palpate.camera import CameraSpec, WindowSpec
from palpate.design import ConeSpec, Design, DomeSpec, EllipsoidSpec, MarkerSpec, MountSpec, place_orientation_mark
from palpate.design.barrel import BarrelSpec
from palpate.design.flat_pad import FlatPadSpec
from palpate.fabrication import FabricationPack, ProcessSpec
from palpate.material import get_material

needs("build123d")
ECOFLEX, SOFT = get_material("zaid_2024_ecoflex_00_30"), get_material("neo-hooke:0.1")
FISHEYE = CameraSpec(
    lens="kannala-brandt", width_px=1280, height_px=960, fx_px=440, fy_px=440, cx_px=639.5, cy_px=479.5, distance=20
)
PAD = FlatPadSpec(height=3.5, base_radius=10.375, thickness=0.5, stretch=1.217, squareness=6.0, flat_radius=7.5)
BARREL = BarrelSpec(height=90, base_radius=20, thickness=2.5, middle_radius=26)
PAD_DOTS, FLAT = MarkerSpec(ring_diameters=(4.5, 9, 13.5), diameter=0.6), {"working_depth": 1, "working_tilt_deg": 3}
DESIGNS = {
    "H10 T1": (DomeSpec(height=10, thickness=1), MarkerSpec(count=91), {"working_depth": 3}),
    "H20 T2": (DomeSpec(), MarkerSpec(count=169), {}),
    "H20 T2 arc": (DomeSpec(), MarkerSpec(count=169), {"mapping": "arc", "camera_body": "davis346"}),
    "H20 T4": (DomeSpec(thickness=4), MarkerSpec(count=37), {"orientation_mark": False}),
    "H30 T3": (DomeSpec(height=30, thickness=3), MarkerSpec(count=91), {}),
    "ellipsoid": (EllipsoidSpec(height=18, taper=1.6), MarkerSpec(count=61), {}),
    "cone": (ConeSpec(height=20, base_radius=14, flat_radius=5, edge_radius=5), MarkerSpec(count=19), {}),
    "pad": (PAD, PAD_DOTS, FLAT),
    "pad with gel": (PAD, PAD_DOTS, {**FLAT, "gel": True}),
    "barrel": (BARREL, MarkerSpec(rows=4, around=8, pitch=16, diameter=4), {"working_depth": 3, "pour_diameter": 4}),
}


def build(name: str) -> tuple[Design, ProcessSpec, MountSpec]:
    skin, markers, given = DESIGNS[name]
    camera, material, mount = CameraSpec(), ECOFLEX, MountSpec()
    if name == "barrel":
        return Design(skin, markers, FISHEYE), ProcessSpec(working_tilt_deg=0, **given), MountSpec(flange_width=3.5)
    if name.startswith("pad"):
        camera, material = CameraSpec(distance=30), SOFT
    process = {key: value for key, value in given.items() if key != "gel"}
    if "gel" in given:
        camera = CameraSpec(distance=30, window=WindowSpec())
        material = replace(SOFT, gel=get_material("neo-hooke:0.03"))
    return Design(skin, markers, camera, material), ProcessSpec(**process), mount


def find_overlaps(pack: FabricationPack) -> Iterator[str]:
    """Parts that share room, though the sheet does not clamp them; dots of the artwork that meet."""
    parts = read_parts(pack)
    for group in ([one for one in parts if one.startswith("mold")], [one for one in parts if "mold" not in one]):
        for one, other in combinations(group, 2):
            clamped = {one, other} & {"clamp_ring", "end_ring"} and "module" in (one, other)
            if not clamped and parts[one].overlap(parts[other]) > 1e-3:
                yield f"{one} and {other}"
    if "artwork.dxf" not in pack.files:
        return
    turn = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    dots = [
        np.array([list(point)[:2] for point in dot.vertices(turn)])
        for dot in needs("ezdxf").readfile(pack.folder / "artwork.dxf").modelspace().query("ELLIPSE")
    ]
    for one, other in combinations(dots, 2):
        if np.linalg.norm(one.mean(axis=0) - other.mean(axis=0)) < 6:
            gap = np.linalg.norm(one[:, None] - other[None], axis=2).min()
            if gap < 0.25:
                yield f"dots {gap:.2f} mm apart"


def find_impossible_steps(pack: FabricationPack, text: str, bill: dict[str, str]) -> Iterator[str]:
    """Steps that no workshop can do: pours beyond the mix, a part that does not pass, a screw without a thread."""
    volume = pack.volumes["module"] / 1000 / 0.999**3
    mixed = float(bill["elastomer"].split()[0])
    poured = sum(
        float(one) for one in re.findall(r"Pour (?:the remaining )?([\d.]+) mL", text.split("## Inspect")[0])
    )
    gel = re.search(r"opening \(([\d.]+) mL\)", text)
    if not poured <= mixed:
        yield f"{poured} mL poured of {mixed} mL"
    if abs(poured / volume - 1) > 0.06:
        yield f"{poured} mL poured into {volume:.2f} mL"
    if gel and float(bill["gel"].split()[0]) < float(gel[1]):
        yield "less gel mixed than poured"
    bounds = {name: np.ptp(meshio.read(pack.folder / f"{name}.stl").points, axis=0) for name in pack.volumes}
    if "template.stl" in pack.files:
        shell = meshio.read(pack.folder / "template.stl").points
        opening = 2 * meshio.read(pack.folder / "module.stl").points[:, :2]
        if np.ptp(shell, axis=0)[0] > np.abs(opening[:, 0]).max():
            yield "template wider than the flange"
    if max(max(one) for one in bounds.values()) > 300:
        yield "part larger than the printer"
    if ("set template.stl" in text) != ("template.stl" in pack.files) or ("artwork.dxf" in text) != (
        "artwork.dxf" in pack.files
    ):
        yield "a step with a file that the pack lacks"


def find_wrong_numbers(pack: FabricationPack, text: str, design: Design) -> Iterator[str]:
    """Numbers of sheet and bill that differ from the parts."""
    with (pack.folder / "bill_of_materials.csv").open() as file:
        rows = {row["part"]: row for row in csv.DictReader(file)}
    for name in rows.keys() & pack.volumes.keys() - {"window", "rods"}:
        volume = float(re.search(r"([\d.]+) mL", rows[name]["specification"])[1])
        if abs(volume - pack.volumes[name] / 1000) > 0.06:
            yield f"{name}: {volume} mL, solid {pack.volumes[name] / 1000:.2f} mL"
    with (pack.folder / "markers.csv").open() as file:
        markers = len(list(csv.DictReader(file)))
    if markers != len(design.layout) or f"All {markers} dots" not in text:
        yield "number of markers"
    mold = [meshio.read(pack.folder / f"{one}.stl").points for one in pack.volumes if one.startswith("mold_cavity")]
    if found := re.search(r"covers the cavity \(([\d.]+) mm (?:by ([\d.]+) mm|across)\)", text):
        size = np.ptp(np.concatenate(mold), axis=0)[:2]
        if np.abs(size - [float(one or found[1]) for one in found.groups()]).max() > 0.1:
            yield f"cavity {found[0]}, {size}"
    opens = float(re.search(r"opens by ([\d.]+) mm", rows["mold clamp"]["specification"])[1])
    tall = np.ptp(meshio.read(pack.folder / "mold_core.stl").points[:, 2])
    if opens < tall - 0.6:
        yield f"clamp opens by {opens} mm, mold {tall:.1f} mm"
    if found := re.search(r"near column (\d+), row (\d+)", text):
        place = design.camera.project(place_orientation_mark(design.skin, design.layout))
        if np.abs(place - [int(one) for one in found.groups()]).max() > 0.51:
            yield "place of the orientation mark"
    thin = float(re.search(r"(?:Thickness at the apex|both ends:) ([\d.]+) mm", text)[1])
    if thin != design.skin.thickness:
        yield f"thickness {thin} mm"


@pytest.mark.slow
@pytest.mark.parametrize("name", DESIGNS)
def test_a_pack_has_no_overlap_no_impossible_step_and_no_wrong_number(name: str) -> None:
    design, process, mount = build(name)
    pack = stored_pack(design, process, mount)
    text = (pack.folder / "instructions.md").read_text()
    with (pack.folder / "bill_of_materials.csv").open() as file:
        bill = {row["part"]: row["quantity"] for row in csv.DictReader(file)}
    found = {
        "overlaps": list(find_overlaps(pack)),
        "impossible steps": list(find_impossible_steps(pack, text, bill)),
        "wrong numbers": list(find_wrong_numbers(pack, text, design)),
    }
    assert found == {kind: [] for kind in found}
