"""One manufactured unit of a design: its printed markers, its camera and its images."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from palpate.calibration import Deviation
from palpate.camera import Camera, RenderSpec, marker_outlines, render, tangent_pair
from palpate.core import BoolArray, FloatArray, child_seed, generator
from palpate.design import Design, place_orientation_mark, turn_about_axis
from palpate.fea import Press
from palpate.surrogate import interpolate_depths


@dataclass(frozen=True, eq=False)
class SimulatedUnit:
    """A sensor that was built to a design and deviates from it.

    Attributes
    ----------
    design
        The design; the inner surface of a unit is as designed.
    deviation
        Manufacturing errors.
    light
        Light, lens and image sensor; light and dirt stay, the noise is new in every image.
    """

    design: Design
    deviation: Deviation = field(default_factory=Deviation)
    light: RenderSpec = field(default_factory=RenderSpec)

    @cached_property
    def camera(self) -> Camera:
        """The camera as mounted."""
        return self.deviation.built(self.design).camera

    @property
    def printed(self) -> BoolArray:
        """(n,) whether each marker of the layout was printed."""
        return self._print[1]

    @property
    def edges(self) -> FloatArray:
        """Edges (m, k, 3) mm of the printed markers at rest; the orientation mark is the last."""
        return self._print[0]

    @cached_property
    def _print(self) -> tuple[FloatArray, BoolArray]:
        rng, skin, layout = generator(self.deviation.seed, "print"), self.design.skin, self.design.layout
        points = np.vstack([layout.positions, place_orientation_mark(skin, layout)])
        x, y = points[:, 0] + self.deviation.print_shift_x, points[:, 1] + self.deviation.print_shift_y
        printed = skin.inner_point(np.hypot(x, y), np.arctan2(y, x))
        first, second = tangent_pair(skin.normal(printed))
        off = self.deviation.marker_position * rng.uniform(-1.0, 1.0, (len(points), 2))
        points = skin.nearest(printed + off[:, :1] * first + off[:, 1:] * second)
        there = np.ones(len(points), bool)
        there[:-1] = rng.permutation(len(layout)) >= round(self.deviation.missing * len(layout))
        return marker_outlines(skin, points, layout.diameter)[there], there[:-1]

    def render(self, edges: FloatArray, noise_seed: int) -> NDArray[np.uint8]:
        """Render the image (h, w) of markers with displaced edges (m, k, 3) mm."""
        return render(self.camera, edges, self.light.model_copy(update={"noise_seed": noise_seed}))

    def render_rest(self) -> NDArray[np.uint8]:
        """Render the rest image (h, w)."""
        return self.render(self.edges, child_seed(self.light.seed, "noise", "rest"))

    def press_edges(self, press: Press, depths: FloatArray | None = None) -> FloatArray:
        """Edges (d, m, k, 3) mm of the markers at the increments of a press, or at depths (d,) mm."""
        own = turn_about_axis(np.radians(press.obstacle.turn_deg)) if press.mesh.spec.whole else np.eye(3)
        moved = press.positions(self.edges.reshape(-1, 3) @ own) @ own.T  # a whole model was solved at azimuth 0
        moved = moved if depths is None else interpolate_depths(press, moved, depths)
        return moved.reshape(-1, *self.edges.shape)

    def render_press(self, press: Press) -> list[NDArray[np.uint8]]:
        """Render the images (h, w) of a press at its increments, rest included."""
        obstacle = press.obstacle
        return [
            self.render(edges, child_seed(self.light.seed, "noise", obstacle.radial, obstacle.turn_deg, number))
            for number, edges in enumerate(self.press_edges(press))
        ]
