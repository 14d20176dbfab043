"""Sub-pixel blob centres by a least-squares fit of a blurred elliptic disc.

The blob is A·Φ((1 - q) R / s) on a constant background, with Φ the normal distribution, q² = dᵀ S d the elliptic
radius of the offset d from the centre (1 at the edge), R its mean radius and s the blur of the edge. The model is
linearised in centre, contrast, background, size and blur; least squares over the window gives the step. Size and blur
are even in d and the shift is odd, so errors in them cannot bias the centre. If the model is valid, the step reaches
the bound of Cramér and Rao, sigma ≥ 2 (noise / A) √(s / (√π · diameter)). Pixels of other blobs are left out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, kernel

_UNKNOWNS = 6
"""Centre, contrast, background, size and blur."""
_ROOM = 4096
"""Maximum number of pixels of a window; a larger one is subsampled."""


@kernel
def fit_centres(
    image: NDArray[np.float32],
    labels: NDArray[np.int32],
    own: NDArray[np.int32],
    start: FloatArray,
    edge: float,
    rounds: tuple[int, int],
) -> FloatArray:
    """Fit the centres of all blobs of an image (h, w), in which blobs are above zero.

    Parameters
    ----------
    image, labels
        (h, w) grey levels, and the label of each pixel's component, 0 outside.
    own, start
        (n,) label of each blob, and (n, 5) column, row and covariance xx, xy, yy (px²) of a disc of its size (a
        quarter of its axes²).
    edge, rounds
        Initial blur of the edge, px; number of steps with free size and blur, and with both fixed.

    Returns
    -------
    ndarray
        (n, 7): column, row, scale of the start's axes, contrast, blur (px), standard deviation of a coordinate for
        noise 1, rms residual; column is NaN if the fit failed.
    """
    result = np.empty((len(own), 7))
    rows = np.empty((_UNKNOWNS + 1, _ROOM))
    for blob in range(len(own)):
        _fit_one(image, labels, own[blob], start[blob], edge, rounds, rows, result[blob])
    return result


@kernel
def _fit_one(
    image: NDArray[np.float32],
    labels: NDArray[np.int32],
    own: int,
    start: FloatArray,
    edge: float,
    rounds: tuple[int, int],
    rows: FloatArray,
    result: FloatArray,
) -> None:
    column, row, scale, blur = start[0], start[1], 1.0, edge
    contrast, spread, residual = 0.0, np.inf, 0.0
    radius = 2.0 * (start[2] * start[4] - start[3] * start[3]) ** 0.25
    for number in range(rounds[0] + rounds[1]):
        free = _UNKNOWNS if number < rounds[0] else _UNKNOWNS - 2
        count = _gather(image, labels, own, start, (column, row, scale, blur), free, rows)
        if count < 2 * _UNKNOWNS:
            column = np.nan
            break
        moments = np.zeros((free + 1, free + 1))
        for i in range(free + 1):
            for j in range(i + 1):
                total = 0.0
                for k in range(count):  # innermost, so that it is done four at a time
                    total += rows[i, k] * rows[j, k]
                moments[i, j] = total
        if free == _UNKNOWNS:
            # size and blur are held near where they were: a small dot does not tell them apart from contrast
            moments[4, 4] += 0.005 * moments[2, 2] / max(radius * radius, 1.0)
            moments[5, 5] += 0.020 * moments[2, 2] / max(radius * radius, 1.0)
        step = _solve(moments, free)
        contrast = step[2]
        if not contrast > 0.0:
            column = np.nan
            break
        square = moments[free, free]
        for i in range(free):
            square -= step[i] * moments[free, i]
        residual = np.sqrt(max(square, 0.0) / max(count - free, 1))
        spread = 1.0 / (np.sqrt(min(moments[0, 0], moments[1, 1])) * contrast)
        largest = 0.4 * radius + 0.3
        column += min(max(step[0] / contrast, -largest), largest)
        row += min(max(step[1] / contrast, -largest), largest)
        if free == _UNKNOWNS:
            scale = min(max(scale + min(max(step[4] / contrast, -0.5), 0.5) / radius, 0.5), 1.8)
            blur = min(max(blur + min(max(step[5] / contrast, -0.3), 0.3), 0.45), 0.6 * radius + 0.5)
        if abs(column - start[0]) > radius + 1.0 or abs(row - start[1]) > radius + 1.0:
            column = np.nan
            break
    result[0], result[1], result[2], result[3] = column, row, scale, contrast
    result[4], result[5], result[6] = blur, spread, residual


@kernel
def _gather(
    image: NDArray[np.float32],
    labels: NDArray[np.int32],
    own: int,
    start: FloatArray,
    state: tuple[float, float, float, float],
    free: int,
    rows: FloatArray,
) -> int:
    """Fill the rows of a step: contrast × centre slopes, contrast, background, size, blur; grey level."""
    column, row, scale, blur = state
    determinant = start[2] * start[4] - start[3] * start[3]
    radius = 2.0 * determinant**0.25 * scale
    grow = 4.0 * scale * scale * determinant
    sxx, sxy, syy = start[4] / grow, -start[3] / grow, start[2] / grow
    reach = 1.0 + (2.2 * blur + 0.6) / radius
    half_x = int(2.0 * scale * np.sqrt(start[2]) * reach) + 1
    half_y = int(2.0 * scale * np.sqrt(start[4]) * reach) + 1
    stride = 1
    while (2 * half_x + 2) * (2 * half_y + 2) > _ROOM * stride * stride:
        stride += 1
    count, height, width = 0, image.shape[0], image.shape[1]
    for v in range(max(int(row) - half_y, 0), min(int(row) + half_y + 2, height), stride):
        for u in range(max(int(column) - half_x, 0), min(int(column) + half_x + 2, width), stride):
            x, y = u - column, v - row
            q = np.sqrt(sxx * x * x + 2.0 * sxy * x * y + syy * y * y)
            if q > reach or (labels[v, u] != 0 and labels[v, u] != own):
                continue
            inside = (1.0 - q) * radius
            exponential = np.exp(-0.5 * (inside / blur) ** 2)
            bell = exponential / (2.5066282746310002 * blur)  # √2π
            along = radius * bell / max(q, 1e-6)
            rows[0, count] = along * (sxx * x + sxy * y)
            rows[1, count] = along * (sxy * x + syy * y)
            rows[2, count] = 0.5 * (1.0 + _erf(inside / (1.4142135623730951 * blur), exponential))
            rows[3, count] = 1.0
            if free == _UNKNOWNS:
                rows[4, count] = bell
                rows[5, count] = -bell * inside / blur
            rows[free, count] = image[v, u]
            count += 1
    return count


@kernel
def _solve(moments: FloatArray, free: int) -> FloatArray:
    """Solve the normal equations by Cholesky factors; the last row is the right side. Zero if singular."""
    factor = np.zeros((free, free))
    step = np.zeros(free)
    for i in range(free):
        for j in range(i + 1):
            value = moments[i, j]
            for k in range(j):
                value -= factor[i, k] * factor[j, k]
            if i == j:
                if value <= 1e-12 * moments[i, i]:
                    return step
                factor[i, i] = np.sqrt(value)
            else:
                factor[i, j] = value / factor[j, j]
    for i in range(free):
        value = moments[free, i]
        for k in range(i):
            value -= factor[i, k] * step[k]
        step[i] = value / factor[i, i]
    for i in range(free - 1, -1, -1):
        value = step[i]
        for k in range(i + 1, free):
            value -= factor[k, i] * step[k]
        step[i] = value / factor[i, i]
    return step


@kernel
def _erf(x: float, exponential: float) -> float:
    """Return the error function to 1.5e-7 (Abramowitz and Stegun 7.1.26), given exp(-x²)."""
    t = 1.0 / (1.0 + 0.3275911 * abs(x))
    series = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))))
    value = 1.0 - series * exponential
    return value if x >= 0.0 else -value
