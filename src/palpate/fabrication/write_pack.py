"""Writing of fabrication packs: complete, or not at all."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import PalpateError, atomic_folder, provenance
from palpate.core.report import write_csv
from palpate.design import (
    ContactModule,
    Design,
    Finding,
    MarkerSpec,
    MountSpec,
    Severity,
    SurfaceMesh,
    build_contact_module,
    place_orientation_mark,
    raise_on_errors,
    write_step,
)
from palpate.fabrication.artwork import draw_artwork
from palpate.fabrication.bill_of_materials import bill_of_materials
from palpate.fabrication.check_parts import (
    check_enclosure,
    check_frame,
    check_interference,
    check_mold,
    check_window,
)
from palpate.fabrication.check_process import check_process
from palpate.fabrication.drawing_sheet import TitleBlock
from palpate.fabrication.enclosure import build_enclosure
from palpate.fabrication.flange_key import build_notch
from palpate.fabrication.folder import hash_files
from palpate.fabrication.frame import plan_frame
from palpate.fabrication.instructions import write_instructions, write_markdown
from palpate.fabrication.mesh_file import write_mesh
from palpate.fabrication.mold import build_mold
from palpate.fabrication.pack import FabricationPack, PackContent
from palpate.fabrication.pack_drawings import TURNED, draw_pack
from palpate.fabrication.pdf_sheet import write_sheet
from palpate.fabrication.pins import build_dimples, build_pins
from palpate.fabrication.spec import ProcessSpec
from palpate.fabrication.template import build_template
from palpate.fabrication.window_plate import WindowPlate, build_window
from palpate.fabrication.write_artwork import draw_page, write_cut, write_dxf, write_pdf, write_svg

MANIFEST = "manifest.json"
_HOLLOW = 1e-3
"""Maximum relative deviation of the shrunk hollow of a mold from the volume of its module."""
_PIXELS = 110
"""Pixels of a picture per inch."""
_CLAMPED = [frozenset((ring, "module")) for ring in ("clamp_ring", "end_ring")]
_UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])


def write_pack(
    folder: Path,
    design: Design,
    process: ProcessSpec = ProcessSpec(),  # noqa: B008  (a spec is frozen)
    mount: MountSpec = MountSpec(),  # noqa: B008  (frozen as well)
) -> FabricationPack:
    """Write everything a workshop needs to make a contact module and its enclosure, into an empty folder.

    The distance of the design's camera places the camera in the enclosure.

    Raises
    ------
    PalpateError
        If a limit of fabrication is exceeded, or the folder cannot be written; it is then unchanged.
    """
    layout, camera = design.layout, design.camera
    build_contact_module(design.skin, mount)  # refuses what has none before anything is checked
    findings = check_process(design, process)
    raise_on_errors(findings)
    with atomic_folder(folder) as work:
        made = _make(design, process, mount)
        findings = (
            *findings,
            *check_enclosure(made.module, made.enclosure, process),
            *check_mold(made.mold, process),
            *_check_filling(made),
            *(check_frame(made.enclosure.frame, layout, camera) if made.enclosure.frame else ()),
        )
        findings = _write_solids(work, made, findings)
        _write_print(work, made)
        _write_sheets(work, made, findings)
        volumes = {name: solid.volume for name, solid in made.solids.items()}
        files = hash_files(work)
        _write_manifest(work / MANIFEST, made, (files, volumes, findings))
    return FabricationPack(folder, files, volumes, findings)


def _check_filling(made: PackContent) -> tuple[Finding, ...]:
    if made.window is None:
        return ()
    return tuple(check_window(made.window, made.design.layout, made.gel, made.design.camera, made.process))


def _make(design: Design, process: ProcessSpec, mount: MountSpec) -> PackContent:
    skin, layout = design.skin, design.layout
    module = build_contact_module(skin, mount)
    window = _build_window(design, process, module)
    scale = 1 / (1 - process.shrinkage_percent / 100)
    marked = process.orientation_mark
    scaled, depth = build_contact_module(skin, mount, scale), process.dot_depth
    holes = [*build_pins(skin, layout, scale, mark=marked), *build_dimples(skin, layout, depth, scale, mark=marked)]
    frame = plan_frame(module, layout) if skin.hole else None
    enclosure = build_enclosure(module, design.camera_spec.distance, process, window, frame)
    mold = build_mold(scaled, process, holes)
    body = module.solid().cut(build_notch(module)).join(*build_pins(skin, layout, 1.0, mark=marked))
    missed = mold.hollow() / scale**3 / body.volume - 1
    if abs(missed) > _HOLLOW:
        raise PalpateError(
            f"The mold's hollow deviates from the module's volume by {100 * missed:.2g} %.",
            "Report this design.",
            code="mold-volume-off",
        )
    check_interference(mold.parts)
    check_interference({**enclosure.parts, "module": body}, intended=_CLAMPED)
    artwork = None if skin.hole else draw_artwork(skin, layout, process.mapping, mark=marked)
    solids = {"module": body, **mold.parts, **enclosure.parts}
    gel = design.material.gel.name if design.material.gel else ""
    return PackContent(design, mount, process, module, mold, enclosure, artwork, solids, gel, window)


def _build_window(design: Design, process: ProcessSpec, module: ContactModule) -> WindowPlate | None:
    """Build the window of a filled skin; `None` without gel."""
    gel, window = design.material.gel, design.camera_spec.window
    if gel is None:
        return None
    if window is None:
        raise PalpateError(
            f"The skin is filled with {gel.name}, which needs a window, but the camera's spec lacks it.",
            "Give its thickness in mm and refractive indices: --window 2,1.49,1.41.",
            code="window-missing",
        )
    return build_window(module, window.thickness, process)


def _write_solids(work: Path, made: PackContent, findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Write STEP of the assemblies, and STL and 3MF of every part as printed."""
    write_step(work / "module.step", "contact_module", {"module": made.solids["module"]})
    write_step(work / "mold.step", "mold", made.mold.parts)
    write_step(work / "enclosure.step", "enclosure", {**made.enclosure.parts, "module": made.solids["module"]})
    meshes = {name: _for_printer(name, solid.mesh()) for name, solid in made.solids.items()}
    if made.artwork is not None:
        try:
            meshes["template"] = build_template(made.design.skin, made.design.layout, made.process)
        except PalpateError as error:
            findings = (*findings, Finding(Severity.NOTE, "no-template", error.problem, error.remedy))
    for name, mesh in meshes.items():
        for suffix in ("stl", "3mf"):
            write_mesh(work / f"{name}.{suffix}", mesh, made.solids[name].volume if name in made.solids else None)
    return findings


def _for_printer(name: str, mesh: SurfaceMesh) -> SurfaceMesh:
    """Place a part on the bed: a cavity with its opening up, everything else as drawn."""
    return mesh.turned(_UPSIDE_DOWN if name in TURNED else np.eye(3))


def _write_print(work: Path, made: PackContent) -> None:
    artwork = made.artwork
    if artwork is not None:
        write_dxf(work / "artwork.dxf", artwork)
        write_svg(work / "artwork.svg", artwork)
        write_pdf(work / "artwork.pdf", artwork, _block(made))
    if made.window is not None:
        write_cut(work / "window.dxf", made.window.line)
    columns = ["marker", "x_mm", "y_mm", "z_mm", *([] if artwork is None else ["page_x_mm", "page_y_mm"])]
    pages = np.empty((len(made.design.layout), 0)) if artwork is None else artwork.dots
    places = np.hstack([made.design.layout.positions, pages])
    rows = ([number, *(f"{value:.4f}" for value in place)] for number, place in enumerate(places))
    write_csv(work / "markers.csv", rows, columns)
    if artwork is not None and artwork.mark is not None:
        mark = place_orientation_mark(made.design.skin, made.design.layout)
        write_csv(work / "orientation_mark.csv", [[f"{value:.4f}" for value in (*mark, *artwork.mark)]], columns[1:])


def _block(made: PackContent) -> TitleBlock:
    skin = made.design.skin
    size = f"H {skin.height:g}  T {skin.thickness:g}  B {skin.base_radius:g} mm, {len(made.design.layout)} markers"
    return TitleBlock(size, made.design.material.name)


def _write_sheets(work: Path, made: PackContent, findings: tuple[Finding, ...]) -> None:
    table, block = bill_of_materials(made), _block(made)
    figures = draw_pack(made, {str(row["part"]): int(str(row["number"])) for row in table.rows})
    for name, figure in figures.items():
        block.draw(figure, name.replace("_", " "))
        figure.savefig(work / f"{name}.png", dpi=_PIXELS)
    sections = write_instructions(made, findings)
    write_csv(work / "bill_of_materials.csv", table.rows, [column.name for column in table.columns])
    write_markdown(work / "instructions.md", sections, [f"{name}.png" for name in figures])
    pages = [] if made.artwork is None else [draw_page(made.artwork, block)]
    write_sheet(work / "instructions.pdf", sections, [*figures.values(), *pages], block)


def _markers_data(design: Design) -> dict[str, Any]:
    if isinstance(design.markers, MarkerSpec):
        return design.markers.model_dump(mode="json")
    return {"positions_mm": design.layout.positions.tolist(), "diameter": design.layout.diameter}


def _write_manifest(
    path: Path, made: PackContent, found: tuple[dict[str, str], dict[str, float], tuple[Finding, ...]]
) -> None:
    files, volumes, findings = found
    data = {
        "made_by": provenance(),
        "design": {
            "dome": made.design.skin_spec.model_dump(mode="json"),
            "markers": _markers_data(made.design),
            "mount": made.mount.model_dump(mode="json"),
            "material": made.design.material.name,
            **({"gel": made.design.material.gel.name} if made.design.material.gel else {}),
            "process": made.process.model_dump(mode="json"),
            "camera": made.design.camera_spec.model_dump(mode="json"),
        },
        "volumes_mm3": volumes,
        "findings": [asdict(finding) for finding in findings],
        "sha256": files,
    }
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
