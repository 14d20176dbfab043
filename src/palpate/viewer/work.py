"""Long computations of the design page in separate processes: a press, a fabrication pack."""

from __future__ import annotations

import tempfile
import zipfile
from pathlib import Path

from palpate.core.run import Progress
from palpate.fabrication import write_pack
from palpate.fea import Press, solve_press
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
    with tempfile.TemporaryDirectory(prefix="palpate-pack-") as name:
        folder, archive = Path(name) / "pack", Path(name) / "pack.zip"
        write_pack(folder, sketch.design, sketch.process)
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
            for path in sorted(folder.iterdir()):
                file.write(path, f"pack/{path.name}")
        return archive.read_bytes()
