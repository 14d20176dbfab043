"""Sums over groups of dots: what every ring that might be printed adds to a normal matrix."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from palpate.core import FloatArray, IntArray


def sum_by_group(left: FloatArray, right: FloatArray, group: IntArray) -> FloatArray:
    """Products (g, n, k) of the rows (m, 2, n) and (m, 2, k) of dots, added up by their group (m,), from 0.

    What is not known of a dot, NaN, adds nothing.
    """
    order = np.argsort(group, kind="stable")
    ends = np.searchsorted(group[order], np.arange(int(group.max()) + 2))
    found = np.zeros((len(ends) - 1, left.shape[-1], right.shape[-1]))
    first, second = (np.nan_to_num(rows)[order] for rows in (left, right))
    for number, (start, end) in enumerate(pairwise(ends)):
        one, other = (rows[start:end].reshape(2 * (end - start), rows.shape[-1]) for rows in (first, second))
        found[number] = one.T @ other
    return found
