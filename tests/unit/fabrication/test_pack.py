"""A whole pack: every file read again, and nothing left behind when it cannot be made."""

import csv
import hashlib
import json
import re
import xml.etree.ElementTree as ElementTree

import meshio
import numpy as np
import pytest
from step_files import read_parts

from errors import refused
from needs import needs
from palpate.camera import CameraSpec
from palpate.design import Design, DomeSpec, MarkerSpec, Severity
from palpate.fabrication import FabricationPack, ProcessSpec, check_process, write_pack
from palpate.fabrication.enclosure import SCREWS
from palpate.material import get_material

needs("build123d")
MATERIAL = get_material("zaid_2024_ecoflex_00_30")


def pack_of(dome: DomeSpec | None = None, markers: MarkerSpec | None = None, **process) -> tuple[Design, ProcessSpec]:
    markers = markers or MarkerSpec(count=37)
    return Design(dome or DomeSpec(), markers, CameraSpec(), MATERIAL), ProcessSpec(**process)


def test_write_pack_leaves_all_that_the_manifest_says(pack: FabricationPack) -> None:
    manifest = json.loads((pack.folder / "manifest.json").read_text())
    for name, digest in manifest["sha256"].items():
        assert hashlib.sha256((pack.folder / name).read_bytes()).hexdigest() == digest
    assert {path.name for path in pack.folder.iterdir()} == {*manifest["sha256"], "manifest.json"}
    assert manifest["design"]["dome"]["height"] == 20


def test_every_stl_is_closed_for_another_reader_and_keeps_the_volume(pack: FabricationPack) -> None:
    for name, volume in pack.volumes.items():
        mesh = meshio.read(pack.folder / f"{name}.stl")
        _, number = np.unique(mesh.points, axis=0, return_inverse=True)
        triangles = number.reshape(-1)[mesh.cells_dict["triangle"]]
        edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]).tolist()
        assert len({tuple(edge) for edge in edges}) == len(edges)
        assert {(b, a) for a, b in edges} == {(a, b) for a, b in edges}
        corners = mesh.points.astype(float)[mesh.cells_dict["triangle"]]
        found = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        assert found == pytest.approx(volume, rel=5e-3)


def test_every_3mf_opens_elsewhere_in_millimetres(pack: FabricationPack) -> None:
    lib3mf = needs("lib3mf")
    for name in pack.volumes:
        model = lib3mf.Wrapper().CreateModel()
        model.QueryReader("3mf").ReadFromFile(str(pack.folder / f"{name}.3mf"))
        assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
        meshes = model.GetMeshObjects()
        meshes.MoveNext()
        assert meshes.GetCurrentMeshObject().IsManifoldAndOriented()


def test_step_has_the_parts_by_name_and_volume(pack: FabricationPack) -> None:
    read_parts(pack)


def test_dots_of_dxf_and_svg_lie_where_the_table_says(pack: FabricationPack) -> None:
    ezdxf = needs("ezdxf")
    with (pack.folder / "markers.csv").open() as file:
        page = np.array([[float(row["page_x_mm"]), float(row["page_y_mm"])] for row in csv.DictReader(file)])
    document = ezdxf.readfile(pack.folder / "artwork.dxf")
    assert document.dxfversion == "AC1024"
    assert document.units == ezdxf.units.MM
    drawn = [dot.dxf.center for dot in document.modelspace().query('ELLIPSE[layer=="DOTS"]')]
    assert np.array([[point.x, point.y] for point in drawn]) == pytest.approx(page, abs=1e-3)
    root = ElementTree.parse(pack.folder / "artwork.svg").getroot()
    group = next(node for node in root if node.get("id") == "dots")
    vector = np.array([[float(node.get("cx")), -float(node.get("cy"))] for node in group])
    assert vector == pytest.approx(page, abs=1e-3)
    assert float(root.get("width").removesuffix("mm")) == pytest.approx(float(root.get("viewBox").split()[2]))


def test_the_sheet_names_the_volumes_to_mix(pack: FabricationPack) -> None:
    text = (pack.folder / "instructions.md").read_text()
    half = pack.volumes["module"] / 1000 / (1 - 0.001) ** 3 * 1.3 / 2
    assert f"part A {half:.2f} mL" in text
    pours = [float(amount) for amount in re.findall(r"Pour (?:the remaining )?([\d.]+) mL", text)]
    assert len(pours) == 2
    assert sum(pours) == pytest.approx(2 * half / 1.3, abs=0.1), "the mold holds what is poured"
    assert f"{SCREWS} screws M3 × 10" in text
    sheet = (pack.folder / "instructions.pdf").read_bytes()
    assert sheet.startswith(b"%PDF")
    boxes = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", sheet)
    assert len(boxes) == 11, "two pages of text, table, seven drawings, artwork"
    assert all((float(w), float(h)) == pytest.approx((595, 842), abs=2) for w, h in boxes), "all on A4"
    assert (pack.folder / "artwork.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (pack_of(dome=DomeSpec(height=8, base_radius=6, thickness=12)), ("not-a-shell",)),
        (pack_of(markers=MarkerSpec(count=169, diameter=3.5)), ("dots-too-near",)),
        (pack_of(markers=MarkerSpec(count=7, diameter=0.2)), ("dot-too-small", "0.4")),
        (pack_of(pour_diameter=12), ("pour-hole-too-wide", "12")),
    ],
)
def test_a_design_that_cannot_be_made_leaves_nothing(
    spec: tuple[Design, ProcessSpec], message: tuple[str, ...], tmp_path
) -> None:
    with refused(*message):
        write_pack(tmp_path / "pack", *spec)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_something_in_it_is_left_as_it_is(tmp_path) -> None:
    (tmp_path / "mine.txt").write_text("x")
    with refused("folder-exists"):
        write_pack(tmp_path, *pack_of())
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_folder_that_cannot_be_written_is_refused(tmp_path) -> None:
    (tmp_path / "file").write_text("")
    with refused("file-unwritable"):
        write_pack(tmp_path / "file" / "pack", *pack_of())


def codes(dome: DomeSpec, markers: MarkerSpec, **process) -> dict[str, Severity]:
    findings = check_process(Design(dome, markers, material=MATERIAL), ProcessSpec(**process))
    return {finding.code: finding.severity for finding in findings}


def test_check_process_reports_each_limit_of_the_workshop() -> None:
    assert codes(DomeSpec(), MarkerSpec(count=169)) == {}
    assert codes(DomeSpec(height=30), MarkerSpec(count=7))["peel-stretch"] is Severity.WARNING
    assert codes(DomeSpec(), MarkerSpec(count=169), max_slope_deg=45)["pad-reach"] is Severity.WARNING
    assert codes(DomeSpec(), MarkerSpec(count=7, diameter=0.5))["dot-in-pixels"] is Severity.WARNING
    assert codes(DomeSpec(height=5, base_radius=5), MarkerSpec(count=7, diameter=2))["dot-on-curve"]
    wide = MarkerSpec(count=169, diameter=2.4)
    assert codes(DomeSpec(), wide, orientation_mark=False)["dots-too-near"] is Severity.WARNING
    assert codes(DomeSpec(), wide)["dots-too-near"] is Severity.ERROR, "the mark overlaps a dot"
