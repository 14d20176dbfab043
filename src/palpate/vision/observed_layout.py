"""Layout of a sensor without a design: its markers at rest, with permanent indices.

Markers are numbered from the centre outwards, ring by ring of one spacing, and within a ring by angle. The indices
are stored with the places in the model; blobs of another rest image are assigned to these places
(`palpate.vision.match_markers`), so small displacements do not change the indices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from palpate.core import FloatArray, IntArray, PalpateError

NEIGHBOURS = 8
"""Maximum number of neighbours of a marker. By hand."""
LEAST_DOTS = 6
"""Minimum number of markers of a layout. By hand."""
_LONGEST = 1.7
"""Maximum length of an edge to a neighbour, over the median of the marker's shortest three. By hand."""


@dataclass(frozen=True, eq=False)
class ObservedLayout:
    """Markers at rest.

    Attributes
    ----------
    rest_px
        (m, 2) positions in the order of their indices, px.
    """

    rest_px: FloatArray

    def __len__(self) -> int:
        return len(self.rest_px)

    @cached_property
    def neighbours(self) -> IntArray:
        """Indices (m, 8) of a marker's neighbours by distance, filled with -1."""
        return _find_neighbours(self.rest_px)

    @cached_property
    def spacing_px(self) -> FloatArray:
        """Median distance (m,) of a marker to its neighbours, px."""
        near, there = self.neighbours, self.neighbours >= 0
        far = np.linalg.norm(self.rest_px[near] - self.rest_px[:, None], axis=-1)
        return np.asarray(np.nanmedian(np.where(there, far, np.nan), axis=1))

    @cached_property
    def harmonics(self) -> tuple[FloatArray, FloatArray]:
        """Smooth fields (m, k) over the layout and their roughness (k,): eigenvectors of the neighbour graph."""
        count = len(self)
        graph = np.zeros((count, count))
        for dot, row in enumerate(self.neighbours):
            graph[dot, row[row >= 0]] = 1.0
        graph = np.maximum(graph, graph.T)
        values, vectors = np.linalg.eigh(np.diag(graph.sum(axis=1)) - graph)
        kept = min(count, max(10, round(0.2 * count)))
        return vectors[:, :kept] * np.sqrt(count), np.maximum(values[:kept] / max(values[-1], 1e-9), 0.0)


def number_markers(positions_px: FloatArray) -> ObservedLayout:
    """Number the markers of a rest image, whose blobs (m, 2) px may be in any order.

    Raises
    ------
    PalpateError
        If there are too few, or they lie on a line.
    """
    if len(positions_px) < LEAST_DOTS:
        raise PalpateError(
            f"The rest image shows {len(positions_px)} blobs, at least {LEAST_DOTS} are needed.",
            "Choose another rest image, or train on pixels alone: --estimators picture.",
            code="rest-markers-few",
        )
    middle = positions_px.mean(axis=0)
    spacing = float(np.median(cKDTree(positions_px).query(positions_px, 2)[0][:, 1]))
    apart = positions_px - middle
    ring = np.rint(np.linalg.norm(apart, axis=1) / spacing)
    angle = np.round(np.arctan2(apart[:, 1], apart[:, 0]), 6)
    layout = ObservedLayout(np.ascontiguousarray(positions_px[np.lexsort((angle, ring))], dtype=float))
    if not (layout.neighbours >= 0).any(axis=1).all():
        raise PalpateError(
            "The blobs of the rest image lie on a line, or some of them have no neighbour.",
            "Choose another rest image.",
            code="rest-markers-on-line",
        )
    return layout


def _find_neighbours(places: FloatArray) -> IntArray:
    try:
        first, *_ = starts = Delaunay(places).vertex_neighbor_vertices
    except QhullError as error:
        raise PalpateError(
            "The blobs of the rest image lie on a line.", "Choose another rest image.", code="rest-markers-on-line"
        ) from error
    near = np.full((len(places), NEIGHBOURS), -1)
    for dot in range(len(places)):
        around = starts[1][first[dot] : first[dot + 1]]
        if not len(around):  # a copy of another
            continue
        far = np.linalg.norm(places[around] - places[dot], axis=1)
        order = np.argsort(far, kind="stable")
        around, far = around[order], far[order]
        kept = around[far <= _LONGEST * np.median(far[:3])][:NEIGHBOURS]
        near[dot, : len(kept)] = kept
    return near
