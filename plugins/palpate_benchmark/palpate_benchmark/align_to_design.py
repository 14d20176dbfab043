"""Input of the baselines on markers: motion since rest, added to the rest image of the design."""

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
    """Return the marker positions (m, 2) px of the nominal design at rest."""
    layout = place_markers(build_skin(design.skin), design.marker_layout)
    return build_camera(benchmark.spec.camera).project(layout.positions)


def align_to_design(found: SplitMarkers, rest_px: FloatArray) -> FloatArray:
    """Return images (n, m, 2) px as the camera of the nominal design would see them.

    Displacements since rest are rotated and scaled by the similarity that maps the unit's rest image to the design's.
    A missing marker takes the mean motion of its nearest neighbours.

    Parameters
    ----------
    found
        Marker positions of one design.
    rest_px
        (m, 2) markers of the nominal design at rest.
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
    """Build the training set of one design; the calibration units are its validation set.

    Parameters
    ----------
    benchmark, design
        Data set, and one of its designs.
    jitter_px
        Jitter of the marker coordinates in training.
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
    """Fit the rotation and scale (2, 2) of row vectors that maps points (k, 2) to others, up to a shift."""
    first, second = ((points - points.mean(axis=0)) @ [1.0, 1.0j] for points in (seen, wanted))
    turn = np.vdot(first, second) / np.vdot(first, first)
    return np.array([[turn.real, turn.imag], [-turn.imag, turn.real]])
