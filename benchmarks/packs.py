"""Write the fabrication packs of the paper's 48 designs, read them again by other programs, and print what differs.

    python benchmarks/packs.py --out docs/results/packs.csv

A design already in the file is not made again.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import ezdxf
import lib3mf
import meshio
import numpy as np

from palpate.core import PalpateError
from palpate.design import Design, DomeSpec, MarkerSpec, MountSpec
from palpate.design.solid import read_step
from palpate.fabrication import PadMapping, ProcessSpec, project_to_skin, write_pack

HEIGHTS, THICKNESSES, MARKERS = (10, 20, 30), (1, 2, 3, 4), (7, 37, 91, 169)
COLUMNS = [
    "height_mm",
    "thickness_mm",
    "markers",
    "files",
    "wall_s",
    "cpu_s",
    "mesh_volume_off_percent",
    "step_volume_off_percent",
    "hollow_off_percent",
    "artwork_off_mm",
    "carried_off_mm",
    "findings",
]


def read_stl(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of an STL file, by meshio."""
    mesh = meshio.read(path)
    return mesh.points, mesh.cells_dict["triangle"]


def read_3mf(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a 3MF file, by lib3mf."""
    model = lib3mf.Wrapper().CreateModel()
    model.QueryReader("3mf").ReadFromFile(str(path))
    found = model.GetMeshObjects()
    found.MoveNext()
    mesh = found.GetCurrentMeshObject()
    points = np.array([list(vertex.Coordinates) for vertex in mesh.GetVertices()])
    return points, np.array([list(triangle.Indices) for triangle in mesh.GetTriangleIndices()])


def volume(points: np.ndarray, triangles: np.ndarray) -> float:
    """Volume of a closed mesh; an error where an edge is not shared by two triangles that run against each other."""
    _, number = np.unique(points, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[triangles]
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]).tolist()
    forward = {tuple(edge) for edge in edges}
    if len(forward) != len(edges) or any((b, a) not in forward for a, b in forward):
        raise SystemExit("A mesh is not closed.")
    corners = points[np.unique(number.reshape(-1), return_index=True)[1]][triangles]
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def check(folder: Path, design: Design, process: ProcessSpec) -> dict[str, float]:
    """Greatest deviations of a pack from what it was made for."""
    manifest = json.loads((folder / "manifest.json").read_text())
    for name, digest in manifest["sha256"].items():
        if hashlib.sha256((folder / name).read_bytes()).hexdigest() != digest:
            raise SystemExit(f"{name} is not what the manifest says.")
    volumes = manifest["volumes_mm3"]
    mesh_off = step_off = 0.0
    for path in [*folder.glob("*.stl"), *folder.glob("*.3mf")]:
        found = volume(*(read_stl if path.suffix == ".stl" else read_3mf)(path))
        if path.stem in volumes:
            mesh_off = max(mesh_off, abs(found / volumes[path.stem] - 1))
    parts = {
        name: part
        for file in ("module", "mold", "enclosure")
        for name, part in read_step(folder / f"{file}.step").items()
    }
    if set(parts) != set(volumes):
        raise SystemExit(f"STEP has the parts {sorted(parts)}, the manifest {sorted(volumes)}.")
    for name, part in parts.items():
        step_off = max(step_off, abs(part.volume / volumes[name] - 1))
    scale = 1 - process.shrinkage_percent / 100
    return {
        "mesh_volume_off_percent": 100 * mesh_off,
        "step_volume_off_percent": 100 * step_off,
        "hollow_off_percent": 100 * abs(hollow(parts, design, process) * scale**3 / volumes["module"] - 1),
        **check_artwork(folder, design, process),
    }


def hollow(parts: dict, design: Design, process: ProcessSpec) -> float:
    """Volume in mm³ that cavity and core leave between them: block minus both, pins and holes left out."""
    from palpate.design import build_contact_module, cylinder, revolve

    module = build_contact_module(design.skin, MountSpec(), 1 / (1 - process.shrinkage_percent / 100))
    top = module.skin.height + module.skin.thickness
    inner = cylinder(module.flange_foot, module.foot, top + 0.5)
    left = inner
    for name, part in parts.items():
        if name.startswith("mold_"):
            left = left.cut(part)
    whole = revolve(module.outside()).volume
    return min(left.volume, whole)


def check_artwork(folder: Path, design: Design, process: ProcessSpec) -> dict[str, float]:
    """Greatest distance of a dot in DXF and SVG from the compensated place, and on the dome from the marker."""
    dome, layout = design.skin, design.layout
    with (folder / "markers.csv").open() as file:
        page = np.array([[float(row["page_x_mm"]), float(row["page_y_mm"])] for row in csv.DictReader(file)])
    ellipses = ezdxf.readfile(folder / "artwork.dxf").modelspace().query('ELLIPSE[layer=="DOTS"]')
    drawn = np.array([[ellipse.dxf.center.x, ellipse.dxf.center.y] for ellipse in ellipses])
    group = next(node for node in ElementTree.parse(folder / "artwork.svg").getroot() if node.get("id") == "dots")
    vector = np.array([[float(node.get("cx")), -float(node.get("cy"))] for node in group])
    off = max(np.linalg.norm(found - page, axis=1).max() for found in (drawn, vector))
    carried = np.linalg.norm(project_to_skin(dome, vector, process.mapping) - layout.positions, axis=1).max()
    return {"artwork_off_mm": float(off), "carried_off_mm": float(carried)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mapping", type=PadMapping, default=PadMapping.AXIS)
    parser.add_argument("--out", type=Path, default=Path("packs.csv"))
    given = parser.parse_args()
    done = set()
    if given.out.exists():
        with given.out.open() as file:
            done = {tuple(int(row[key]) for key in COLUMNS[:3]) for row in csv.DictReader(file)}
    with given.out.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if not done:
            writer.writeheader()
        for design in [(h, t, m) for h in HEIGHTS for t in THICKNESSES for m in MARKERS]:
            if design in done:
                continue
            dome = DomeSpec(height=design[0], thickness=design[1])
            process = ProcessSpec(mapping=given.mapping)
            made = Design(dome, MarkerSpec(count=design[2]))
            row: dict[str, object] = dict(zip(COLUMNS[:3], design, strict=True))
            with tempfile.TemporaryDirectory() as folder:
                started = time.perf_counter(), time.process_time()
                try:
                    pack = write_pack(Path(folder) / "pack", made, process)
                except PalpateError as error:
                    row |= {"findings": str(error)}
                else:
                    row |= {"files": len(list(pack.folder.iterdir())), "wall_s": time.perf_counter() - started[0]}
                    row |= {"cpu_s": time.process_time() - started[1], **check(pack.folder, made, process)}
                    row |= {"findings": " ".join(item.code for item in pack.findings)}
            writer.writerow({k: f"{v:.3g}" if isinstance(v, float) else v for k, v in row.items()})
            file.flush()
            print(*row.values(), flush=True)


if __name__ == "__main__":
    main()
