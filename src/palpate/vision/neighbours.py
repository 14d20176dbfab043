"""Neighbours among a few hundred points; compiled searches, for which a tree costs more than it saves."""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, kernel


def largest_group(pairs: IntArray, wanted: BoolArray) -> BoolArray:
    """(m,) wanted points in the largest group of them that pairs (k, 2) connect."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(wanted), len(wanted)))
    _, group = connected_components(graph, directed=False)
    return np.asarray(wanted & (group == np.bincount(group[wanted]).argmax()))


@kernel
def nearest(points: FloatArray, others: FloatArray) -> tuple[IntArray, FloatArray]:
    """Number of the nearest of `others` (k, 2) to each of `points` (n, 2), and its distance."""
    number = np.full(len(points), -1)
    distance = np.full(len(points), np.inf)
    for i in range(len(points)):
        for j in range(len(others)):
            square = (points[i, 0] - others[j, 0]) ** 2 + (points[i, 1] - others[j, 1]) ** 2
            if square < distance[i]:
                distance[i] = square
                number[i] = j
        distance[i] = np.sqrt(distance[i])
    return number, distance


@kernel
def nearest_distance(points: FloatArray, most: float) -> FloatArray:
    """(n,) distance of each point to the nearest other one, at most `most`."""
    square = np.full(len(points), most**2)
    for i in range(len(points)):
        for j in range(i):
            apart = (points[i, 0] - points[j, 0]) ** 2 + (points[i, 1] - points[j, 1]) ** 2
            square[i] = min(square[i], apart)
            square[j] = min(square[j], apart)
    return np.sqrt(square)


@kernel
def agree(predicted: FloatArray, blobs: FloatArray, near: IntArray, reach: FloatArray, rounds: int) -> FloatArray:
    """Predictions (m, 2) moved, round by round, by the median miss of those in the neighbourhood that found a dot.

    A marker has found a dot if each is the nearest of the other and they are within `reach` (m,); `near` (m, k) are
    the numbers of its neighbours, itself first. Where no neighbour found one, the median of all is taken.
    """
    moved = predicted.copy()
    for _ in range(rounds):
        blob, distance = nearest(moved, blobs)
        back, _ = nearest(blobs, moved)
        found = np.zeros(len(moved), np.bool_)
        for i in range(len(moved)):
            found[i] = blob[i] >= 0 and back[blob[i]] == i and distance[i] < reach[i]
        if not found.any():
            break
        miss = np.zeros_like(moved)
        for i in range(len(moved)):
            if found[i]:
                miss[i] = blobs[blob[i]] - moved[i]
        overall = np.array([np.median(miss[found, 0]), np.median(miss[found, 1])])
        step = np.empty_like(moved)
        for i in range(len(moved)):
            around = near[i][found[near[i]]]
            if len(around) == 0:
                step[i] = overall
            else:
                step[i, 0] = np.median(miss[around, 0])
                step[i, 1] = np.median(miss[around, 1])
        moved += step
    return moved
