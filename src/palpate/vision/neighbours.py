"""Neighbours among a few hundred points, by compiled searches that are faster than a tree."""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, kernel


def largest_group(pairs: IntArray, wanted: BoolArray) -> BoolArray:
    """Return the wanted points (m,) in the largest group of them that pairs (k, 2) connect."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(wanted), len(wanted)))
    _, group = connected_components(graph, directed=False)
    return np.asarray(wanted & (group == np.bincount(group[wanted]).argmax()))


@kernel
def nearest(points: FloatArray, others: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the index of the nearest of `others` (k, 2) to each of `points` (n, 2), and its distance."""
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
    """Return the distance (n,) of each point to its nearest neighbour, at most `most`."""
    square = np.full(len(points), most**2)
    for i in range(len(points)):
        for j in range(i):
            apart = (points[i, 0] - points[j, 0]) ** 2 + (points[i, 1] - points[j, 1]) ** 2
            square[i] = min(square[i], apart)
            square[j] = min(square[j], apart)
    return np.sqrt(square)


@kernel
def agree(predicted: FloatArray, blobs: FloatArray, near: IntArray, reach: FloatArray, rounds: int) -> FloatArray:
    """Correct predictions (m, 2) in rounds by the median residual of neighbouring markers with a blob.

    A marker has a blob if they are mutual nearest neighbours within `reach` (m,); `near` (m, k) are the indices of
    its neighbours, itself first. If no neighbour has a blob, the median of all is used.
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
