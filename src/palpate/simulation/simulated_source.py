"""Simulated sensor for use without hardware: repeated presses of a skin, seen by its camera."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from palpate.camera import RenderSpec, Source
from palpate.core import FloatArray, child_seed, generator
from palpate.fea import Press, WallSpec, solve_press
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import Unit
from palpate.simulation.simulated_unit import SimulatedUnit

_CELLS = 10
"""Coarse mesh, solved in seconds, accurate enough for display. By hand."""
_REST_IMAGES = 10
"""Number of images before the first press. By hand."""
_STEP = 0.2
"""Travel of the wall between two images, mm. By hand."""
LIGHT = RenderSpec(vignetting=0.2, unevenness=0.1, blur_px=0.7, noise=2.0)


@final
class SimulatedSource(Source):
    """Images of a skin at rest and through presses, loading and unloading, with the true pose of each.

    Parameters
    ----------
    unit
        The sensor; its markers are at their design positions.
    touches
        Solved presses of its skin in sequence, after which the source ends.
    """

    def __init__(self, unit: Unit, touches: Iterable[Press]) -> None:
        self._touches = touches
        self._unit = SimulatedUnit(replace(unit.design, camera_spec=unit.camera_spec), light=LIGHT)
        self._truth: tuple[float, ...] = (0.0, 0.0, 0.0)

    @property
    def name(self) -> str:
        return "simulated sensor"

    @property
    def truth(self) -> tuple[float, ...]:
        """Pose in the last returned image by the obstacle's space, rx, ry (degrees), depth (mm); 0 at rest."""
        return self._truth

    def images(self) -> Iterator[NDArray[np.uint8]]:
        for number, (pose, edges) in enumerate(self._poses()):
            self._truth = pose
            yield self._unit.render(edges, child_seed(LIGHT.seed, "noise", number))

    def _poses(self) -> Iterator[tuple[tuple[float, ...], FloatArray]]:
        """Pose of the obstacle and edges (m, k, 3) of the markers in every image."""
        for _ in range(_REST_IMAGES):
            yield (0.0, 0.0, 0.0), self._unit.edges
        for press in self._touches:
            wall = press.obstacle
            down = np.arange(0.0, press.depth[-1], _STEP)
            depths = np.append(down, down[::-1])
            for depth, edges in zip(depths, self._unit.press_edges(press, depths), strict=True):
                yield tuple(wall.pose_space.pose(wall.radial, wall.turn_deg, float(depth)).tolist()), edges


def simulate_sensor(
    unit: Unit, tilt_deg: float = 5.0, azimuth_deg: float = 30.0, presses: int = 3
) -> SimulatedSource:
    """Simulate a sensor that a tilted wall presses; takes some seconds.

    Parameters
    ----------
    unit
        The sensor.
    tilt_deg, azimuth_deg
        The wall.
    presses
        Number of presses.

    Raises
    ------
    PalpateError
        If the press cannot be solved, or the skin is no body of revolution.
    """
    skin, material = unit.design.skin, unit.design.material
    skin.require_revolution("its one press is turned to other azimuths", "Simulate a dome, or a round pad.")
    depth = min(8.0, 0.4 * skin.height)
    wall = WallSpec(tilt_deg=tilt_deg, azimuth_deg=azimuth_deg, depth=depth, depth_step=0.8)
    mesh = mesh_skin(skin, MeshSpec(cells=_CELLS, filled=material.has_gel))
    press = solve_press(mesh, material, wall)
    return SimulatedSource(unit, presses * [press])


def sample_presses(presses: Sequence[Press], seed: int = 0) -> Iterator[Press]:
    """Yield solved presses of half a skin in random order without end, each at a random azimuth."""
    rng = generator(seed, "touches")
    while True:
        press, azimuth = presses[int(rng.integers(len(presses)))], float(rng.uniform(0.0, 360.0))
        yield replace(press, obstacle=press.obstacle.model_copy(update={"azimuth_deg": azimuth}))
