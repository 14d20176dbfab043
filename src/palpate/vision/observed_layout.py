"""The layout of a sensor that nobody wrote down: its dots at rest, numbered in an order that lasts.

Dots are numbered from the middle outwards, ring by ring of one spacing, and in a ring by their angle. The numbers are
kept with the places in the model, so that another image at rest, where a dot lies a little elsewhere, does not change
them: there dots are assigned to the kept ones (`palpate.vision.match_markers`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from palpate.core import FloatArray, IntArray, PalpateError

NEIGHBOURS = 8
"""Most neighbours of a dot that are kept."""
LEAST_DOTS = 6
"""Least number of dots of a layout."""
_LONGEST = 1.7
"""An edge to a neighbour is at most so much longer than the median of the dot's shortest three."""


@dataclass(frozen=True, eq=False)
class ObservedLayout:
    """Dots at rest.

    Attributes
    ----------
    rest_px
        (m, 2) places in the order of their numbers, px.
    """

    rest_px: FloatArray

    def __len__(self) -> int:
        return len(self.rest_px)

    @cached_property
    def neighbours(self) -> IntArray:
        """(m, 8) numbers of a dot's neighbours by their distance, -1 where it has fewer."""
        return _find_neighbours(self.rest_px)

    @cached_property
    def spacing_px(self) -> FloatArray:
        """(m,) median distance of a dot to its neighbours, px."""
        near, there = self.neighbours, self.neighbours >= 0
        far = np.linalg.norm(self.rest_px[near] - self.rest_px[:, None], axis=-1)
        return np.asarray(np.nanmedian(np.where(there, far, np.nan), axis=1))

    @cached_property
    def harmonics(self) -> tuple[FloatArray, FloatArray]:
        """Smooth fields (m, k) over the layout and how rough each is (k,): eigenvectors of the neighbours' graph."""
        count = len(self)
        graph = np.zeros((count, count))
        for dot, row in enumerate(self.neighbours):
            graph[dot, row[row >= 0]] = 1.0
        graph = np.maximum(graph, graph.T)
        values, vectors = np.linalg.eigh(np.diag(graph.sum(axis=1)) - graph)
        kept = min(count, max(10, round(0.2 * count)))
        return vectors[:, :kept] * np.sqrt(count), np.maximum(values[:kept] / max(values[-1], 1e-9), 0.0)


def number_markers(positions_px: FloatArray) -> ObservedLayout:
    """Number the dots of an image at rest.

    Parameters
    ----------
    positions_px
        (m, 2) dots in any order, px.

    Raises
    ------
    PalpateError
        If there are too few, or they lie on a line.
    """
    if len(positions_px) < LEAST_DOTS:
        raise PalpateError(
            f"The image at rest shows {len(positions_px)} dots, {LEAST_DOTS} are needed.",
            "Choose another image at rest, or learn from pictures alone: --estimators picture.",
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
            "The dots at rest lie on a line, or some of them have no neighbour.",
            "Choose another image at rest.",
            code="rest-markers-on-line",
        )
    return layout


def _find_neighbours(places: FloatArray) -> IntArray:
    try:
        first, *_ = starts = Delaunay(places).vertex_neighbor_vertices
    except QhullError as error:
        raise PalpateError(
            "The dots at rest lie on a line.", "Choose another image at rest.", code="rest-markers-on-line"
        ) from error
    near = np.full((len(places), NEIGHBOURS), -1)
    for dot in range(len(places)):
        around = starts[1][first[dot] : first[dot + 1]]
        far = np.linalg.norm(places[around] - places[dot], axis=1)
        order = np.argsort(far, kind="stable")
        around, far = around[order], far[order]
        kept = around[far <= _LONGEST * np.median(far[:3])][:NEIGHBOURS]
        near[dot, : len(kept)] = kept
    return near
