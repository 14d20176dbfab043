"""Whether blobs are a printed field: dots stand in order or are alike, glints and grain do neither."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from palpate.core import FloatArray
from palpate.markers.blobs import Blobs
from palpate.markers.choose_field import AT_RANDOM, FieldCandidate, is_midpoint

_IN_ORDER, _ABOVE_CHANCE = 0.25, 5.0
"""Share of dots half way between two neighbours, and standard deviations of that above chance, of a field in order.

The public images that show dots have 0.32 and 6.0 or more, one excepted whose dots are alike; grain has up to 0.2."""
_CLEAR = 30.0
"""Least contrast over the noise of a pixel times the diameter, px: a faint weave has less, faint printed dots 44."""
_AT_BORDER, _NOT_LONG = 0.25, 0.59
"""Greatest share of dots cut by the image's border, and least median ratio of axes: a weave runs on beyond the image,
and its pieces are long; public images have at most 0.08 and at least 0.69."""
_NEIGHBOURS, _ONE_WAY = 6, 0.7
"""Neighbours looked at, and how far their arms may point one way."""
_DISC = 0.95
"""Median ratio of axes above which dots are discs, and no threads, whatever way they run."""
_ALIKE, _FEWEST, _ROUND = 0.06, 8, 0.75
"""Greatest spread of the contrast of dots that are alike, of what they are at least, and their median ratio of axes:
up to seven lamps about a dome are as alike as print."""


def is_printed(blobs: Blobs, field: FieldCandidate) -> bool:
    """Whether blobs look printed.

    Parameters
    ----------
    blobs
        Those of an image.
    field
        What was chosen to find them.
    """
    count = len(blobs)
    if count < _FEWEST or blobs.at_border.mean() > _AT_BORDER or field.roundness < _NOT_LONG:
        return False
    clear = float(np.median(blobs.contrast)) / blobs.noise * float(np.median(blobs.diameter_px)) > _CLEAR
    share = float(is_midpoint(blobs.positions_px).mean())
    above = (share - AT_RANDOM) * np.sqrt(count / (AT_RANDOM * (1.0 - AT_RANDOM)))
    in_order = share > _IN_ORDER and above > _ABOVE_CHANCE
    alike = _spread(np.log(np.maximum(blobs.contrast, 1e-9))) < _ALIKE and field.roundness > _ROUND
    one_way = field.roundness < _DISC and _in_one_direction(blobs.positions_px) > _ONE_WAY
    return bool(clear and not one_way and (in_order or alike))


def _in_one_direction(points: FloatArray) -> float:
    """How far the straightest arms of all dots point one way: 1 for a weave's threads, near 0 for grids and rings."""
    distance, number = cKDTree(points).query(points, min(_NEIGHBOURS + 1, len(points)))
    arms, length = points[number[:, 1:]] - points[:, None], distance[:, 1:]
    miss = np.linalg.norm(arms[:, :, None] + arms[:, None], axis=-1) / (length[:, :, None] + length[:, None])
    best = miss.reshape(len(points), -1).argmin(axis=1) // arms.shape[1]
    arm = arms[np.arange(len(points)), best]
    return float(np.abs(np.mean(np.exp(2j * np.arctan2(arm[:, 1], arm[:, 0])))))


def _spread(values: FloatArray) -> float:
    """Standard deviation by the median of the distances from the median."""
    return float(1.4826 * np.median(np.abs(values - np.median(values))))
