"""Long computations of the pages: a press, its export, a fabrication pack."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

from palpate.core.run import Progress
from palpate.fabrication import write_pack
from palpate.fea import Press, export_press, solve_press
from palpate.mesh import MeshSpec, mesh_skin
from palpate.viewer.sketch import DesignDraft


def press_sketch(sketch: DesignDraft, progress: Progress) -> Press:
    """Solve the press of a draft by its obstacle; the cost is the depth, mm."""
    mesh = mesh_skin(sketch.design.skin, sketch.material.mesh(MeshSpec()))
    wall, what = sketch.obstacle, "press"
    progress.plan(wall.depth)
    progress.begin(what, wall.depth)
    return solve_press(mesh, sketch.design.material, wall, on_increment=lambda depth: progress.advance(what, depth))


def pack_sketch(sketch: DesignDraft, progress: Progress) -> bytes:
    """Make the fabrication pack of a draft as a zip file, without progress reports."""
    return _zip_folder("pack", lambda folder: write_pack(folder, sketch.design, sketch.process))


def press_archive(press: Press) -> bytes:
    """Export a press for ParaView, as `palpate press --export`, as a zip file.

    Raises
    ------
    PalpateError
        As `palpate.fea.export_press`.
    """
    return _zip_folder("press", lambda folder: export_press(folder, press))


def _zip_folder(name: str, write: Callable[[Path], object]) -> bytes:
    """Return the folder of this name that `write` makes as a zip file."""
    with tempfile.TemporaryDirectory(prefix=f"palpate-{name}-") as place:
        folder, archive = Path(place) / name, Path(place) / f"{name}.zip"
        write(folder)
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
            for path in sorted(folder.iterdir()):
                file.write(path, f"{name}/{path.name}")
        return archive.read_bytes()
