"""Simulation of one built unit: presses by a twin, marker positions with noise, and rendered images.

The position of a marker is the centroid of its outline in the image, as a detector would measure it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from palpate.calibration import CONTACT_STATE, Deviation, sample_deviation
from palpate.camera import project_markers
from palpate.core import FloatArray, IntArray, child_seed, generator
from palpate.core.state import State
from palpate.design import Design, PoseDensity, rotation_vector, wall_normal
from palpate.simulation import SimulatedUnit, TwinBackend
from palpate.surrogate import Twin
from palpate_benchmark.spec import BenchmarkDesign, BenchmarkSpec
from palpate_benchmark.unit_images import LABELS, UnitImages

_DIGITS = 4
"""Decimal places of the labels; pose, depth and friction are rounded before the simulation."""


class UnitPress(NamedTuple):
    """One press: rx, ry (degrees), friction, 1/µ within the range of the twin, depths (k,) mm, branch."""

    rx: float
    ry: float
    friction: float
    inverse_friction: float
    depths: FloatArray
    inverted: bool


def deviation_of(spec: BenchmarkSpec, design: BenchmarkDesign, unit: int) -> Deviation:
    """Sample the deviation of unit 1, 2, … of a design."""
    return sample_deviation(spec.tolerance, _seed_of(spec, design, unit), unit)


def simulate_unit(spec: BenchmarkSpec, design: BenchmarkDesign, unit: int, twin: Twin) -> UnitImages:
    """Simulate all images of one unit.

    Parameters
    ----------
    spec, design, unit
        Data set, design, and number of the unit, from 1.
    twin
        Twin of the design's skin.
    """
    drawn, seed = build_benchmark_unit(spec, design, unit, twin), _seed_of(spec, design, unit)
    presses = draw_unit_presses(spec, twin, seed, unit)
    outlines, rows, numbers = [], [], []
    for number, press in enumerate(presses):
        for depth in press.depths:
            edges, label = press_unit(drawn, press, float(depth))
            outlines.append(project_markers(drawn.unit.camera, edges[:-1]).centres)
            rows.append(label)
            numbers.append(number)
    noise = generator(seed, "noise", unit)
    rest = project_markers(drawn.unit.camera, drawn.rest_edges[:-1]).centres
    seen = np.full((len(rows) + 1, len(drawn.unit.printed), 2), np.nan)
    seen[:, drawn.unit.printed] = np.array([*outlines, rest])
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


def build_benchmark_unit(spec: BenchmarkSpec, design: BenchmarkDesign, unit: int, twin: Twin) -> TwinBackend:
    """Build one unit; for parameters see `simulate_unit`."""
    light = spec.render.model_copy(update={"seed": child_seed(_seed_of(spec, design, unit), "light", unit)})
    built = Design(design.skin, design.marker_layout, spec.camera)
    return TwinBackend(SimulatedUnit(built, deviation_of(spec, design, unit), light), twin)


def draw_unit_presses(spec: BenchmarkSpec, twin: Twin, seed: int, unit: int) -> list[UnitPress]:
    """Sample the presses of one unit.

    Tilts are uniform over the disc, and friction is within the tolerance. Each press has one depth in each equal part
    of the depth range.
    """
    rng, found = generator(seed, "poses", unit), []
    for _ in range(spec.presses):
        share, turn, rub, state = rng.random(4)
        parts = (np.arange(spec.images) + rng.random(spec.images)) / spec.images
        tilt = PoseDensity.UNIFORM_DISC.radius(share, spec.max_tilt_deg)
        rx, ry = (round(float(each), _DIGITS) for each in rotation_vector(tilt, 2.0 * np.pi * turn))
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


def press_unit(drawn: TwinBackend, press: UnitPress, depth: float) -> tuple[FloatArray, tuple[float, ...]]:
    """Return the marker edges (m, k, 3) mm of a pressed unit, and its `LABELS`."""
    contact = State.zeros(CONTACT_STATE).replace(
        rx_deg=press.rx, ry_deg=press.ry, depth_mm=depth, inverse_friction=press.inverse_friction
    )
    force, normal = drawn.force(contact, press.inverted), wall_normal(*np.radians([press.rx, press.ry]))
    pressing = float(force @ normal)
    shear = float(np.linalg.norm(force - pressing * normal))
    labels = (press.rx, press.ry, depth, round(pressing, _DIGITS), round(shear, _DIGITS), press.friction)
    assert len(labels) == len(LABELS)
    return drawn.edges(contact, press.inverted), labels


def _seed_of(spec: BenchmarkSpec, design: BenchmarkDesign, unit: int) -> int:
    """Return the seed of a unit; units of the test use the hidden seed, if given."""
    hidden = spec.hidden_seed is not None and spec.split_of(unit) == "test"
    return child_seed(spec.hidden_seed if hidden and spec.hidden_seed is not None else spec.seed, design.name)


def _pictures(
    spec: BenchmarkSpec, drawn: TwinBackend, presses: list[UnitPress], chosen: IntArray, seed: int
) -> NDArray[np.uint8]:
    """Render images (k + 1, h, w): the rest image, then the chosen images."""
    if not spec.pictures:
        return np.zeros((0, spec.camera.height_px, spec.camera.width_px), np.uint8)
    outlines = [drawn.rest_edges]
    for image in chosen:
        press = presses[image // spec.images]
        outlines.append(press_unit(drawn, press, float(press.depths[image % spec.images]))[0])
    number = drawn.unit.deviation.unit
    return np.array(
        [
            drawn.unit.render(outline, child_seed(seed, "grain", number, picture))
            for picture, outline in enumerate(outlines)
        ]
    )
