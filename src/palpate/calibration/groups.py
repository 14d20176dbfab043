"""Sums over groups of markers: the contribution of each possible ring to a normal matrix."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from palpate.core import FloatArray, IntArray


def sum_by_group(left: FloatArray, right: FloatArray, group: IntArray) -> FloatArray:
    """Sum the products (g, n, k) of rows (m, 2, n) and (m, 2, k) by the group (m,) of each marker.

    Groups are numbered from 0. NaN adds nothing.
    """
    order = np.argsort(group, kind="stable")
    ends = np.searchsorted(group[order], np.arange(int(group.max()) + 2))
    found = np.zeros((len(ends) - 1, left.shape[-1], right.shape[-1]))
    first, second = (np.nan_to_num(rows)[order] for rows in (left, right))
    for number, (start, end) in enumerate(pairwise(ends)):
        one, other = (rows[start:end].reshape(2 * (end - start), rows.shape[-1]) for rows in (first, second))
        found[number] = one.T @ other
    return found
