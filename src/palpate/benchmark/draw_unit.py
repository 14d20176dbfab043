"""Draw one built unit: presses by a twin of its skin, dots where the camera sees their traces, noise, and pictures.

Of a dot's edge eight points are carried by the surface, and the outline is the trigonometric polynomial through them.
What is noted is the centroid of the outline in the image, as a detector finds it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import resample

from palpate.bench import Deviation, Scene, build_scene
from palpate.benchmark.spec import BenchmarkDesign, BenchmarkSpec
from palpate.benchmark.unit_images import LABELS, UnitImages
from palpate.built import sample_deviation
from palpate.camera import project_markers, render
from palpate.core import FloatArray, IntArray, child_seed, generator
from palpate.design import Design, wall_normal
from palpate.twin import MarkerTwin, Twin

_CORNERS = 32
"""Corners of an outline, as `palpate.camera.flat_marker_outlines` has them."""
_CARRIED = 8
"""Points of it that are carried by the surface."""
_DIGITS = 4
"""Digits of the labels behind the point; they are rounded before anything is drawn."""


class UnitPress(NamedTuple):
    """One press: rx, ry (degrees), friction, 1/µ as the twin takes it, depths (k,) mm, and the state of the skin."""

    rx: float
    ry: float
    friction: float
    inverse_friction: float
    depths: FloatArray
    inverted: bool


@dataclass(frozen=True, eq=False)
class BenchmarkUnit:
    """One unit of a design, ready to be pressed.

    Attributes
    ----------
    deviation
        What is not as designed.
    scene
        Its dots under its camera; the mark is the last.
    printed
        (m,) whether each dot of the layout is there.
    flat, inverted
        Twin of `_CARRIED` points of the edge of every dot, in both states; `None` where there is no other.
    """

    deviation: Deviation
    scene: Scene
    printed: NDArray[np.bool_]
    flat: MarkerTwin
    inverted: MarkerTwin | None


def deviation_of(spec: BenchmarkSpec, design: BenchmarkDesign, unit: int) -> Deviation:
    """How unit 1, 2, … of a design is built."""
    return sample_deviation(spec.tolerance, _seed_of(spec, design, unit), unit)


def simulate_unit(spec: BenchmarkSpec, design: BenchmarkDesign, unit: int, twin: Twin) -> UnitImages:
    """All images of one unit.

    Parameters
    ----------
    spec, design, unit
        Which.
    twin
        Of the design's skin.
    """
    drawn, seed = build_benchmark_unit(spec, design, unit, twin), _seed_of(spec, design, unit)
    presses = draw_unit_presses(spec, twin, seed, unit)
    outlines, rows, numbers = [], [], []
    for number, press in enumerate(presses):
        for depth in press.depths:
            outline, label = press_unit(drawn, press, float(depth))
            outlines.append(project_markers(drawn.scene.camera, outline[:-1]).centres)
            rows.append(label)
            numbers.append(number)
    noise = generator(seed, "noise", unit)
    rest = project_markers(drawn.scene.camera, _outline(drawn.scene.edges[:, :: _CORNERS // _CARRIED])[:-1]).centres
    seen = np.full((len(rows) + 1, len(drawn.printed), 2), np.nan)
    seen[:, drawn.printed] = np.array([*outlines, rest])
    seen += spec.noise_px * noise.standard_normal(seen.shape)
    labels = np.array(rows)
    chosen = np.sort(generator(seed, "pictures", unit).permutation(len(rows))[: spec.pictures])
    return UnitImages(
        markers_px=seen[:-1].astype(np.float32),
        rest_px=seen[-1].astype(np.float32),
        labels=labels,
        inverted=np.array([presses[number].inverted for number in numbers]),
        press=np.array(numbers),
        pictured=chosen,
        pictures=_pictures(spec, drawn, presses, chosen, seed),
    )


def build_benchmark_unit(spec: BenchmarkSpec, design: BenchmarkDesign, unit: int, twin: Twin) -> BenchmarkUnit:
    """Build one unit; parameters are those of `simulate_unit`."""
    deviation = deviation_of(spec, design, unit)
    light = spec.render.model_copy(update={"seed": child_seed(_seed_of(spec, design, unit), "light", unit)})
    scene = build_scene(Design(design.skin, design.marker_layout, spec.camera), deviation, light)
    edges_mm = scene.edges[:, :: _CORNERS // _CARRIED].reshape(-1, 3)
    other = None if twin.inverted is None else twin.inverted.with_markers(edges_mm)
    return BenchmarkUnit(deviation, scene, scene.printed, twin.with_markers(edges_mm), other)


def draw_unit_presses(spec: BenchmarkSpec, twin: Twin, seed: int, unit: int) -> list[UnitPress]:
    """Walls of one unit: even over the disc of tilts, friction within the tolerance, a depth in each equal part."""
    rng, found = generator(seed, "poses", unit), []
    for _ in range(spec.presses):
        share, turn, rub, state = rng.random(4)
        parts = (np.arange(spec.images) + rng.random(spec.images)) / spec.images
        tilt, azimuth = spec.max_tilt_deg * np.sqrt(share), 2.0 * np.pi * turn
        rx, ry = (round(float(tilt * way), _DIGITS) for way in (np.cos(azimuth), np.sin(azimuth)))
        slips, friction = twin.inverse_frictions, np.inf
        if len(slips) > 1 and spec.tolerance.friction_min > 0:
            friction = round(float(spec.tolerance.friction_at(float(rub))), _DIGITS)
        slip = min(1.0 / friction, float(slips[-1]))
        inverted = twin.inverted is not None and bool(state < spec.inverted_share)
        own = twin.inverted if inverted and twin.inverted is not None else twin
        first = max(spec.min_depth, float(own.depths_mm[0]))
        last = min(spec.depth, float(own.depths_mm[-1]), own.max_depth(float(tilt), slip))
        depths = np.round(first + (last - first) * parts, _DIGITS)
        found.append(UnitPress(rx, ry, friction, slip, depths, inverted))
    return found


def press_unit(drawn: BenchmarkUnit, press: UnitPress, depth: float) -> tuple[FloatArray, tuple[float, ...]]:
    """Outlines (m, k, 3) mm of a pressed unit's dots, and its `LABELS`."""
    dots = drawn.inverted if press.inverted and drawn.inverted is not None else drawn.flat
    moved = dots.evaluate(np.array([press.rx, press.ry, depth]), press.inverse_friction, drawn.deviation.thickness)
    force = (1.0 + drawn.deviation.modulus) * moved.force
    tilt, azimuth = np.radians(np.hypot(press.rx, press.ry)), np.arctan2(press.ry, press.rx)
    normal = wall_normal(float(tilt * np.cos(azimuth)), float(tilt * np.sin(azimuth)))
    pressing = float(force @ normal)
    shear = float(np.linalg.norm(force - pressing * normal))
    told = (press.rx, press.ry, depth, round(pressing, _DIGITS), round(shear, _DIGITS), press.friction)
    assert len(told) == len(LABELS)
    return _outline(moved.positions.reshape(-1, _CARRIED, 3)), told


def _seed_of(spec: BenchmarkSpec, design: BenchmarkDesign, unit: int) -> int:
    """Seed of a unit; those of the test may have one that nobody is told."""
    hidden = spec.hidden_seed is not None and spec.split_of(unit) == "test"
    return child_seed(spec.hidden_seed if hidden and spec.hidden_seed is not None else spec.seed, design.name)


def _outline(carried: FloatArray) -> FloatArray:
    """Outlines (m, 32, 3) through points (m, 8, 3) at even parts of a turn."""
    outline: FloatArray = np.moveaxis(resample(np.moveaxis(carried, 1, -1), _CORNERS, axis=-1), -1, 1)
    return outline


def _pictures(
    spec: BenchmarkSpec, drawn: BenchmarkUnit, presses: list[UnitPress], chosen: IntArray, seed: int
) -> NDArray[np.uint8]:
    """Pictures (k + 1, h, w) at rest and of the chosen images."""
    if not spec.pictures:
        return np.zeros((0, spec.camera.height_px, spec.camera.width_px), np.uint8)
    outlines = [_outline(drawn.scene.edges[:, :: _CORNERS // _CARRIED])]
    for image in chosen:
        press = presses[image // spec.images]
        outlines.append(press_unit(drawn, press, float(press.depths[image % spec.images]))[0])
    light = drawn.scene.render
    return np.array(
        [
            render(
                drawn.scene.camera,
                outline,
                light.model_copy(update={"noise_seed": child_seed(seed, "grain", drawn.deviation.unit, number)}),
            )
            for number, outline in enumerate(outlines)
        ]
    )
