"""Skins that are drawn whole, or lie along the axis: a pad in its own frame, a barrel under a wall at its side."""

import json

import numpy as np
import pytest
from viewer_process import viewer
from walk import dots, open_page, slide, wait_for_motion

from palpate.design import SkinSpec, skin_from_data
from palpate.fea import ObstacleSpec, WallSpec, write_press
from palpate.fea.side_wall import SideWallSpec
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from presses import solve_press

PAD = {"kind": "pad", "height": 3.5, "base_radius": 10.4, "thickness": 0.5, "flat_radius": 7.5, "edge_radius": 2.0}
BARREL = {"kind": "barrel", "height": 120.0, "base_radius": 25.0, "middle_radius": 32.0, "thickness": 3.0}


def pad_walls():
    poses = [(0.0, 0.0), (1.0, 0.0), (1.0, 90.0)]
    return [WallSpec(tilt_deg=t, azimuth_deg=a, depth=0.6, depth_step=0.1, contact=0.0) for t, a in poses]


def side_walls():
    return [SideWallSpec(tilt_deg=t, depth=2.0, depth_step=1.0, contact=0.0) for t in (88.0, 90.0, 92.0)]


def write_results(folder, data: dict[str, object], walls: list[ObstacleSpec], meshing: MeshSpec) -> None:
    """A grid of one design with its presses, solved on a coarse mesh."""
    spec: SkinSpec = skin_from_data(data)
    keys = [f"{number:032x}" for number in range(len(walls))]
    for key, wall in zip(keys, walls, strict=True):
        whole = data["kind"] == "pad" and wall.turn_deg > 0
        mesh = mesh_skin(spec.build(), meshing.model_copy(update={"whole": whole}))
        path = folder / "store" / "press" / key[:2] / f"{key}.h5"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_press(path, solve_press(mesh, get_material("neo-hooke:0.1"), wall, SolverSpec(tolerance=1e-5)))
    sizes = {f"{name}_mm": data[name] for name in ("height", "base_radius", "thickness")}
    markers = {"count": 19} if data["kind"] == "pad" else {"rows": 4, "around": 8, "pitch": 25.0}
    count = markers.get("count", 32)
    spec_data = json.dumps({"skin": data, "markers": markers})
    row = {**sizes, "markers": count, "press_key": " ".join(keys), "spec": spec_data}
    tables = {"designs": [row], "by_depth": [], "by_tilt": [], "presses": []}
    (folder / "grid.json").write_text(json.dumps({"format": "palpate specification grid", "version": 2, **tables}))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("data", "walls", "meshing", "pose"),
    [
        (PAD, pad_walls(), MeshSpec(cells=6, core=1), "depth=0.3&tilt=1&azimuth=40"),
        (BARREL, side_walls(), MeshSpec(cells=8, core=2), "depth=2&tilt=91&azimuth=40"),
    ],
    ids=["pad", "barrel"],
)
def test_it_is_drawn_and_follows_the_sliders(page, pictures, tmp_path, data, walls, meshing, pose):
    write_results(tmp_path, data, walls, meshing)
    with viewer(tmp_path) as link:
        open_page(page, link, f"?{pose}")
        page.wait_for_timeout(400)
        page.screenshot(path=pictures / f"{data['kind']}.png")
        before = dots(page)
        slide(page, "azimuth", 220)
        wait_for_motion(page, before, 0, 0.05)
        assert len(before) == (19 if data is PAD else 32)
        assert np.abs(np.array(dots(page)) - before).max() < 40.0
        low, high = page.locator("input[name=tilt]").evaluate("e => [+e.min, +e.max]")
        assert [low, high] == [walls[0].radial, walls[-1].radial]
        page.goto("about:blank")  # before its server goes
