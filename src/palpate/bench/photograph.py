"""Images of a built unit as its camera takes them: printed dots on the inner surface, through a solved press."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.built import Deviation
from palpate.camera import Camera, RenderSpec, marker_outlines, render, tangent_pair
from palpate.core import BoolArray, FloatArray, child_seed, generator
from palpate.design import Design, Skin, place_orientation_mark, turn_about_axis
from palpate.fea import Press


@dataclass(frozen=True, eq=False)
class Scene:
    """What a camera looks at.

    Attributes
    ----------
    edges
        (m, k, 3) mm, edges of the dots that are there on the undeformed inner surface; the mark is the last.
    camera
        The camera as mounted.
    render
        Light, lens and sensor; light and dirt stay, the noise is new in every image.
    printed
        (n,) whether each dot of the layout is there.
    """

    edges: FloatArray
    camera: Camera
    render: RenderSpec
    printed: BoolArray

    def render_rest(self) -> NDArray[np.uint8]:
        """Image (h, w) of the untouched dome."""
        return self._look(self.edges, "rest")

    def render_press(self, press: Press) -> Iterator[NDArray[np.uint8]]:
        """Images (h, w) of a press, rest included; one of a whole model was solved at azimuth 0."""
        own = turn_about_axis(np.radians(press.obstacle.turn_deg)) if press.mesh.spec.whole else np.eye(3)
        flat = press.positions(self.edges.reshape(-1, 3) @ own) @ own.T
        for number, points in enumerate(flat):
            yield self._look(points.reshape(self.edges.shape), press.obstacle.radial, press.obstacle.turn_deg, number)

    def _look(self, edges: FloatArray, *which: str | float) -> NDArray[np.uint8]:
        noise = child_seed(self.render.seed, "noise", *which)
        return render(self.camera, edges, self.render.model_copy(update={"noise_seed": noise}))


def build_scene(design: Design, deviation: Deviation, spec: RenderSpec) -> Scene:
    """Print the dots of one unit and mount its camera.

    Parameters
    ----------
    design
        The design that it was made to; a unit's inner surface is as designed.
    deviation
        What is not as designed.
    spec
        Light, lens and sensor.
    """
    rng, skin, layout = generator(deviation.seed, "print"), design.skin, design.layout
    points = np.vstack([layout.positions, place_orientation_mark(skin, layout)])
    points = _misprint(skin, points, deviation, rng)
    there = np.ones(len(points), bool)
    there[:-1] = rng.permutation(len(layout)) >= round(deviation.missing * len(layout))  # the mark is looked at
    edges = marker_outlines(skin, points, layout.diameter)[there]
    return Scene(edges, deviation.built(design).camera, spec, there[:-1])


def _misprint(skin: Skin, points: FloatArray, deviation: Deviation, rng: np.random.Generator) -> FloatArray:
    """Centres (m, 3) mm as printed: the pad is off as a whole, every dot by itself."""
    x, y = points[:, 0] + deviation.print_shift_x, points[:, 1] + deviation.print_shift_y
    printed = skin.inner_point(np.hypot(x, y), np.arctan2(y, x))
    first, second = tangent_pair(skin.normal(printed))
    off = deviation.marker_position * rng.uniform(-1.0, 1.0, (len(points), 2))
    return skin.nearest(printed + off[:, :1] * first + off[:, 1:] * second)
