"""Baseline that fits each image by a twin, with unit parameters inferred from the rest image."""

from __future__ import annotations

import numpy as np

from palpate.calibration import PoseFitter, build_unit_model, infer_from_rest
from palpate.core import FloatArray, IntArray
from palpate.core.run import Progress
from palpate.design import place_markers
from palpate.surrogate import Twin
from palpate_benchmark.predictions import FORCE, POSE, Predictions, half_width_column
from palpate_benchmark.read_set import BenchmarkSet, SplitMarkers
from palpate_benchmark.spec import BenchmarkDesign


def predict_by_fit(benchmark: BenchmarkSet, design: BenchmarkDesign, twin: Twin, progress: Progress) -> Predictions:
    """Fit every test image of one design.

    Parameters
    ----------
    benchmark, design
        Data set, and one of its designs.
    twin
        Twin of the design's skin, on another mesh than the twin behind the data set.
    progress
        Receives each unit.
    """
    found, spec = benchmark.markers("test", design.name), benchmark.spec
    layout = place_markers(twin.skin, design.marker_layout)
    names = (*POSE, FORCE, *(half_width_column(name) for name in (*POSE, FORCE)))
    table = np.empty((len(found.image), len(names)))
    units = np.unique(found.unit)
    progress.plan(len(units))
    for unit in units:
        what = f"{design.name}: fit of unit {unit}"
        progress.begin(what)
        rest = found.rest_px[int(unit)]
        belief = infer_from_rest(twin, layout, spec.camera, rest, spec.tolerance, spec.noise_px)
        fitter = PoseFitter(build_unit_model(twin, layout, belief, spec.tolerance), spec.noise_px)
        for row in order_images(found, int(unit)):
            fit = fitter.fit(found.markers_px[row])
            force = fit.force.normal_force
            table[row] = (*fit.pose, force.value, *fit.half_width, force.half_width)
        progress.finish(what)
    return Predictions(found.image, dict(zip(names, table.T, strict=True)))


def order_images(found: SplitMarkers, unit: int) -> IntArray:
    """Return the rows of a unit's images in an order in which each fit starts from a similar image.

    The first image is the one nearest to rest; each image is followed by the remaining image that is most similar.
    """
    rows = np.flatnonzero(found.unit == unit)
    moved = np.nan_to_num(found.markers_px[rows] - found.rest_px[unit]).reshape(len(rows), -1)
    left, order = np.ones(len(rows), bool), [int(np.argmin((moved**2).sum(axis=1)))]
    left[order[0]] = False
    while left.any():
        away = _away(moved[left], moved[order[-1]])
        order.append(int(np.flatnonzero(left)[np.argmin(away)]))
        left[order[-1]] = False
    return rows[order]


def _away(many: FloatArray, one: FloatArray) -> FloatArray:
    square: FloatArray = ((many - one) ** 2).sum(axis=1)
    return square
