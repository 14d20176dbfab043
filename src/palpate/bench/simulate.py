"""A simulated sensor: a dome pressed again and again, seen by its camera, for whoever has no sensor at hand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from palpate.bench.deviation import Deviation
from palpate.bench.photograph import Scene, set_scene
from palpate.camera import CameraSpec, RenderSpec, Source
from palpate.core import child_seed
from palpate.design import MarkerLayout, Skin
from palpate.fea import WallSpec, solve_press
from palpate.material import Material
from palpate.mesh import MeshSpec, mesh_skin

_CELLS = 10
"""A coarse mesh is solved in seconds and is good enough to look at."""
_REST_IMAGES = 10
_STEP = 0.2
"""Travel of the wall between two images, mm."""
LIGHT = RenderSpec(vignetting=0.2, unevenness=0.1, blur_px=0.7, noise=2.0)


class SimulatedSource(Source):
    """Images of a dome at rest and through presses of a wall of tilt 5° and azimuth 30°, down and up.

    Parameters
    ----------
    dome, layout, material
        The design.
    presses
        Presses after which it ends.
    """

    def __init__(self, dome: Skin, layout: MarkerLayout, material: Material, presses: int = 3) -> None:
        self._presses = presses
        self._scene = set_scene(dome, layout, Deviation(), CameraSpec(), LIGHT)
        wall = WallSpec(tilt_deg=5.0, azimuth_deg=30.0, depth=min(8.0, 0.4 * dome.height), image_step=0.8)
        self._press = solve_press(mesh_skin(dome, MeshSpec(cells=_CELLS)), material, wall)

    @property
    def name(self) -> str:
        return "simulated sensor"

    def images(self) -> Iterator[np.ndarray]:
        scene, press = self._scene, self._press
        edges = press.positions(scene.edges.reshape(-1, 3))
        down = np.arange(0.0, press.depth[-1], _STEP)
        depths = np.concatenate([np.zeros(_REST_IMAGES), *self._presses * [np.append(down, down[::-1])]])
        for number, depth in enumerate(depths):
            after = int(np.clip(np.searchsorted(press.depth, depth), 1, len(press.depth) - 1))
            share = (depth - press.depth[after - 1]) / (press.depth[after] - press.depth[after - 1])
            points = (1.0 - share) * edges[after - 1] + share * edges[after]
            yield _seen(scene, points.reshape(scene.edges.shape), number)


def _seen(scene: Scene, edges: np.ndarray, number: int) -> np.ndarray:
    from palpate.camera import render

    noise = child_seed(scene.render.seed, "noise", number)
    return render(scene.camera, edges, scene.render.model_copy(update={"noise_seed": noise}))
