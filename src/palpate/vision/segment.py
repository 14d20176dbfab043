"""Segmentation of grey levels into candidate blobs, cut at half their height above the background."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, kernel
from palpate.vision.opencv import blur, box, close, components, dilate, local_maxima

Image = NDArray[np.float32]
MEDIAN_SD, MEDIAN_DISTANCE = 1.4826, 1.1774
"""Normal numbers: standard deviation over median magnitude, median distance in a plane over it."""
_FIELD = 20
"""Number of maxima from which strong ones are a field of markers, not lamps or screws. By hand."""
_NOISE_ROWS = 24
"""Rows in which the noise is measured: rows of 346 px give it to 2 %."""


@dataclass(frozen=True, eq=False)
class Segments:
    """Candidates in one image, cut at half their height.

    Attributes
    ----------
    labels
        (h, w) index of the candidate + 1, 0 outside.
    area_px, middle_px, spread
        (n,) number of pixels, (n, 2) column and row of the mean pixel, (n, 3) covariance xx, xy, yy of the pixels,
        px².
    contrast
        (n,) maximum height.
    at_border
        (n,) whether it touches the image's border.
    """

    labels: NDArray[np.int32]
    area_px: FloatArray
    middle_px: FloatArray
    spread: FloatArray
    contrast: FloatArray
    at_border: BoolArray

    @property
    def diameter_px(self) -> FloatArray:
        """Diameter (n,) of the disc of equal area."""
        return np.sqrt(4.0 / np.pi * self.area_px)

    @property
    def roundness(self) -> FloatArray:
        """Ratio (n,) of the axes, at most 1."""
        return np.sqrt(self._variances()[0] / self._variances()[1])

    @property
    def fullness(self) -> FloatArray:
        """Area (n,) over that of the ellipse of equal spread: 1 for a disc, less for hollow or bent shapes."""
        small, large = self._variances()
        return self.area_px / (4.0 * np.pi * np.sqrt(small * large))

    def _variances(self) -> tuple[FloatArray, FloatArray]:
        xx, xy, yy = self.spread.T
        middle, half = (xx + yy) / 2.0, np.hypot((xx - yy) / 2.0, xy)
        return np.maximum(middle - half, 1.0 / 12.0), middle + half


@dataclass(frozen=True, eq=False)
class Blobs:
    """Blobs of one image, from top to bottom.

    Attributes
    ----------
    positions_px
        (n, 2) centres, column and row.
    diameter_px
        (n,) diameter of the disc of equal area.
    contrast
        (n,) difference to the background, in grey levels of the image, positive.
    sigma_px
        (n,) standard deviation of each coordinate due to image noise; NaN if unknown.
    at_border
        (n,) whether the blob is cut by the image's border.
    noise
        Standard deviation of a pixel, grey levels.
    """

    positions_px: FloatArray
    diameter_px: FloatArray
    contrast: FloatArray
    sigma_px: FloatArray
    at_border: BoolArray
    noise: float

    def __len__(self) -> int:
        return len(self.positions_px)

    def take(self, mask: BoolArray) -> Blobs:
        """Return the blobs of a mask (n,)."""
        names = ("positions_px", "diameter_px", "contrast", "sigma_px", "at_border")
        return replace(self, **{name: getattr(self, name)[mask] for name in names})


def measure_noise(image: Image, step: int = 1) -> float:
    """Return the standard deviation of pixel noise, by the median of second differences (Immerkær 1996).

    It is at least the rounding error of integers, 1/√12. Compression and smoothing correlate the noise of neighbours,
    whose differences then show a part of it; those of pixels `step` apart show more.
    """
    height = image.shape[0] - 2 * step
    first = np.arange(0, height, max(height // _NOISE_ROWS, 1))
    both = image[first] - 2.0 * image[first + step] + image[first + 2 * step]
    both = both[:, : -2 * step] - 2.0 * both[:, step:-step] + both[:, 2 * step :]
    # the mean is what Immerkær takes; the median forgives dots and edges
    return max(float(np.median(np.abs(both))) / 0.6745 / 6.0, 12.0**-0.5)


def heights(image: Image, diameter_px: float) -> tuple[Image, float]:
    """Return the heights (h, w) of dark blobs of one diameter (px), and the factor on the noise.

    The height is the closing of the smoothed image minus the smoothed image.
    """
    sigma = max(0.15 * diameter_px, 0.6)
    smooth = blur(image, sigma)
    size = 2 * round(0.75 * diameter_px + 1.0) + 1
    ground = box(close(smooth, size), size)
    return np.maximum(ground - smooth, 0.0), 1.0 / (2.0 * np.sqrt(np.pi) * sigma)


def segment(height: Image, diameter_px: float, least: float, share: float) -> Segments:
    """Cut candidates out of an image of heights (h, w) by `heights`.

    A blob has a minimum height, and a minimum share of the typical height of the candidates.
    """
    size = 2 * round(0.3 * diameter_px) + 1
    peak = local_maxima(height, size) & (height > least)
    tops = height[peak]
    level = max(least, share * _typical_height(tops, share)) if len(tops) else np.inf
    peak &= height > level
    _, labels = components(_upper_halves(height, _ridge(height, peak, size), level))
    return _describe(labels, height, level)


def _typical_height(tops: Image, share: float) -> float:
    """Return the median of the higher half of maxima (n,), grey levels, or the median weighted by height.

    The latter is for a field: maxima of blurred or compressed noise may be many, but are low and weigh little. A few
    lamps or screws weigh more than faint markers, but are no field.
    """
    ordered = np.sort(tops)
    total = np.cumsum(ordered)
    by_height = float(ordered[np.searchsorted(total, 0.5 * total[-1])])
    is_field = int((tops > share * by_height).sum()) >= _FIELD
    middle = float(np.median(tops[tops >= np.median(tops)]))
    return max(middle, by_height) if is_field else middle


def _ridge(height: Image, peak: BoolArray, size: int) -> Image:
    """Return the height of the nearest strong peak, spread over the blob around it; 0 elsewhere."""
    return dilate(height * peak, 2 * size + 1)


@kernel
def _upper_halves(height: Image, ridge: Image, level: float) -> BoolArray:
    """Return a mask (h, w) of pixels above half the height of their peak and half of `level`."""
    mask = np.empty(height.shape, np.bool_)
    least = np.float32(0.5 * level)
    for y in range(height.shape[0]):
        for x in range(height.shape[1]):
            peak = ridge[y, x]
            mask[y, x] = peak > 0.0 and height[y, x] > np.float32(0.5) * peak and height[y, x] > least
    return mask


def _describe(labels: NDArray[np.int32], height: Image, level: float) -> Segments:
    sums = _add_up(labels, height, int(labels.max(initial=0)) + 1)
    good = np.flatnonzero(sums[:, 6] > level)
    rename = np.zeros(len(sums), np.int32)
    rename[good] = np.arange(1, len(good) + 1)
    area = sums[good, 0]
    x, y, xx, xy, yy = sums[good, 1:6].T / area
    return Segments(
        labels=np.take(rename, labels),
        area_px=area,
        middle_px=np.stack([x, y], axis=-1),
        spread=np.stack([xx - x * x + 1.0 / 12.0, xy - x * y, yy - y * y + 1.0 / 12.0], axis=-1),
        contrast=sums[good, 6],
        at_border=sums[good, 7] > 0.0,
    )


@kernel
def _add_up(labels: NDArray[np.int32], height: Image, count: int) -> FloatArray:
    """Sum up each label (count, 8): pixels, x, y, x², xy, y², maximum height, pixels at the border."""
    sums = np.zeros((count, 8))
    rows, columns = labels.shape
    for y in range(rows):
        for x in range(columns):
            own = labels[y, x]
            if own == 0:
                continue
            total = sums[own]
            total[0] += 1.0
            total[1] += x
            total[2] += y
            total[3] += x * x
            total[4] += x * y
            total[5] += y * y
            total[6] = max(total[6], height[y, x])
            if x == 0 or y == 0 or x == columns - 1 or y == rows - 1:
                total[7] += 1.0
    return sums
