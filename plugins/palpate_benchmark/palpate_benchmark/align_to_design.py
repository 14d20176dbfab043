"""What networks and ridge read: how far dots moved since rest, on the design's image at rest, with gaps filled."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from palpate.camera import build_camera
from palpate.core import FloatArray
from palpate.datasets import Dataset, DatasetSpec
from palpate.design import build_skin, place_markers
from palpate_benchmark.read_set import BenchmarkSet, SplitMarkers
from palpate_benchmark.spec import BenchmarkDesign, Split

_NEIGHBOURS = 6


def design_rest(benchmark: BenchmarkSet, design: BenchmarkDesign) -> FloatArray:
    """Dots (m, 2) px of a design as built without a fault, at rest."""
    layout = place_markers(build_skin(design.skin), design.marker_layout)
    return build_camera(benchmark.spec.camera).project(layout.positions)


def align_to_design(found: SplitMarkers, rest_px: FloatArray) -> FloatArray:
    """Images (n, m, 2) px as the design's camera would see them.

    Displacements since rest are turned and scaled as the unit's image at rest must be to lie on the design's. A dot
    that is not there moves as the mean of its neighbours.

    Parameters
    ----------
    found
        Marker positions of one design.
    rest_px
        (m, 2) the design's dots at rest.
    """
    images = np.empty_like(found.markers_px)
    for unit in np.unique(found.unit):
        rows, rest = found.unit == unit, found.rest_px[int(unit)]
        there = np.isfinite(rest).all(axis=1)
        moved = (found.markers_px[rows] - rest) @ _fit_turn(rest[there], rest_px[there])
        around = np.flatnonzero(there)
        _, near = cKDTree(rest_px[around]).query(rest_px[~there], min(_NEIGHBOURS, len(around)))
        moved[:, ~there] = moved[:, around[near]].mean(axis=2)
        images[rows] = rest_px + moved
    return images


def build_dataset(benchmark: BenchmarkSet, design: BenchmarkDesign, jitter_px: float) -> Dataset:
    """Images that teach one design, with those that calibrate as held out.

    Parameters
    ----------
    benchmark, design
        Which.
    jitter_px
        What networks are trained with.
    """
    sides: tuple[Split, ...] = ("train", "calibrate")
    rest, camera = design_rest(benchmark, design), benchmark.spec.camera
    markers = [benchmark.markers(split, design.name) for split in sides]
    tables = [benchmark.table(split) for split in sides]
    own = [table.design == design.name for table in tables]
    images = np.concatenate([align_to_design(found, rest) for found in markers])
    return Dataset(
        spec=DatasetSpec(jitter_px=jitter_px),
        images_px=images,
        poses=np.concatenate([table.labels[rows, :3] for table, rows in zip(tables, own, strict=True)]),
        press=np.concatenate([table.press[rows] for table, rows in zip(tables, own, strict=True)]),
        validation=np.repeat([False, True], [len(found.image) for found in markers]),
        branch=np.concatenate([table.branch[rows] for table, rows in zip(tables, own, strict=True)]),
        travel_mm=np.zeros(len(images)),
        rest_px=rest,
        image_size_px=(camera.width_px, camera.height_px),
        solved_presses=0,
        dropped={},
    )


def _fit_turn(seen: FloatArray, wanted: FloatArray) -> FloatArray:
    """Turn and scale (2, 2), for rows from the right, by which dots (k, 2) come to lie on others, but for a shift."""
    first, second = ((points - points.mean(axis=0)) @ [1.0, 1.0j] for points in (seen, wanted))
    turn = np.vdot(first, second) / np.vdot(first, first)
    return np.array([[turn.real, turn.imag], [-turn.imag, turn.real]])
