"""A detector: what is looked for, with every choice made."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.vision.centre import fit_centres
from palpate.vision.choose_field import choose_dots, choose_field, is_printed
from palpate.vision.neighbours import largest_group
from palpate.vision.opencv import fill_hull, grow, simple_blobs
from palpate.vision.segment import Blobs, Segments, heights, measure_noise, segment
from palpate.vision.spec import DetectSpec
from palpate.vision.split import split_merged
from palpate.vision.stray_blobs import find_strays

Image = NDArray[np.float32]
_ROUNDS, _ROUNDS_TO_MEASURE = (1, 1), (8, 0)
"""Steps of a fit with size and blur free, and held: in each image, and once to measure the blur."""
_EDGE_PX = 0.8
"""Blur of an edge to begin with: a pixel's own width and a lens in focus."""
_GAP = 2.6
"""Step between dots of one field that is always allowed, over the median distance of nearest neighbours."""
_CLEAR = 40.0
"""Contrast of a blob's sum over its noise at which half of its elongation is believed."""


_LUMA = np.array([0.114, 0.587, 0.299], np.float32)
"""Weights of blue, green and red (ITU-R BT.601), in OpenCV's order."""
_SMALLEST_PX = 8
"""Smallest side of an image."""


@dataclass(frozen=True, eq=False)
class Detector:
    """Finds dots of one polarity and size inside a mask.

    Attributes
    ----------
    spec
        What was chosen.
    dark
        Whether dots are darker than what is about them.
    diameter_px
        Diameter of a dot.
    mask
        (h, w) where dots are looked for; `None` for everywhere.
    edge_px
        Blur of a dot's edge, by lens and pixel.
    """

    spec: DetectSpec
    dark: bool
    diameter_px: float
    mask: BoolArray | None
    edge_px: float = _EDGE_PX

    def find(self, image: NDArray[Any]) -> Blobs:
        """Find the dots of an image.

        Parameters
        ----------
        image
            (h, w) or (h, w, 3), any number type.

        Raises
        ------
        PalpateError
            If it is not an image, is too small or too large, or has another size than the mask.
        """
        grey = to_grey(image, self.spec.largest_mpx)
        if self.mask is not None and self.mask.shape != grey.shape:
            raise PalpateError(
                f"The image has {grey.shape[1]} × {grey.shape[0]} px, the detector was made for "
                f"{self.mask.shape[1]} × {self.mask.shape[0]}.",
                "Make a detector from an image of this size.",
                code="image-size-changed",
            )
        return self._by_opencv(grey) if self.spec.method == "opencv" else self._by_centroid(grey)

    def _by_centroid(self, grey: Image) -> Blobs:
        blobs = self._fit(grey, _ROUNDS)[0]
        strays = find_strays(blobs.positions_px, blobs.diameter_px)
        return blobs.take(~strays) if strays.any() else blobs

    @cached_property
    def _window(self) -> tuple[slice, slice]:
        """Rows and columns that hold the mask: the rest of the image is not looked at."""
        if self.mask is None:
            return slice(None), slice(None)
        rows, columns = np.flatnonzero(self.mask.any(axis=1)), np.flatnonzero(self.mask.any(axis=0))
        return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)

    def _within(self, points_px: FloatArray) -> BoolArray:
        return np.ones(len(points_px), bool) if self.mask is None else inside(self.mask, points_px)

    def _fit(self, grey: Image, rounds: tuple[int, int]) -> tuple[Blobs, float]:
        """Blobs, and the median blur of their edges."""
        corner = np.array([self._window[1].start or 0, self._window[0].start or 0])
        shape, grey = grey.shape, np.ascontiguousarray(grey[self._window])
        raised = -grey if self.dark else grey
        noise = measure_noise(grey)
        height, factor = heights(-raised, self.diameter_px)
        segments = segment(height, self.diameter_px, self.spec.threshold * noise * factor, self.spec.evenness)
        segments = split_merged(segments, height, self._within(segments.middle_px + corner))
        chosen = choose_dots(segments, self.diameter_px, self.spec)
        chosen = chosen[self._within(segments.middle_px[chosen] + corner)]
        blobs, edge = _refine(raised, segments, chosen, noise, (self.edge_px, rounds))
        if self.mask is None:
            return blobs, edge
        positions = blobs.positions_px + corner
        reach = (np.maximum(blobs.diameter_px, 2.0) / 2.0 + 1.0)[:, None]
        cut = np.any((positions < reach) | (positions > np.array(shape)[::-1] - 1 - reach), axis=1)
        return replace(blobs, positions_px=positions, at_border=blobs.at_border & cut), edge

    def _by_opencv(self, grey: Image) -> Blobs:
        low, high = float(grey.min()), float(grey.max())
        scaled = np.rint((grey - low) * (255.0 / max(high - low, 1e-9))).astype(np.uint8)
        found = simple_blobs(scaled, self.diameter_px, self.dark)
        keep = np.ones(len(found), bool) if self.mask is None else inside(self.mask, found[:, :2])
        found = found[keep][np.argsort(found[keep][:, 1], kind="stable")]
        margin = found[:, 2] / 2.0
        x, y = found[:, 0], found[:, 1]
        cut = (x < margin) | (y < margin) | (x > grey.shape[1] - 1 - margin) | (y > grey.shape[0] - 1 - margin)
        unknown = np.full(len(found), np.nan)
        return Blobs(found[:, :2], found[:, 2], unknown, unknown, cut, measure_noise(grey))


def prepare_detector(
    image: NDArray[Any], spec: DetectSpec | None = None, *, doubt: bool = True, gap: float = 0.0
) -> Detector:
    """Choose polarity, size and mask from an image, where the spec leaves them open.

    `palpate.vision.choose_field` says how.

    Parameters
    ----------
    image
        (h, w) or (h, w, 3), any number type.
    spec
        What is known of the dots.
    doubt
        Whether what does not look printed is refused, as lamps and grain; not where dots are held against a design.
    gap
        Greatest step between dots of one field, over the median distance of nearest neighbours; less than 2.6 counts
        as that. What lies further away is masked.

    Raises
    ------
    PalpateError
        If nothing in the image looks like a field of dots. Where polarity and diameter are given, any dots will do.
    """
    spec = spec or DetectSpec()
    grey = to_grey(image, spec.largest_mpx)
    none = PalpateError(
        f"No field of dots was found in the image (grey levels {grey.min():g} to {grey.max():g}).",
        "Check light and focus, or give polarity and diameter_px.",
        code="markers-not-found",
    )
    field = choose_field(grey, spec)
    if field is None:
        raise none
    dark = field.dark
    rough = Detector(spec, dark, spec.diameter_px or field.diameter_px, None)
    blobs, edge = rough._fit(grey, _ROUNDS_TO_MEASURE)
    mask = _find_mask(blobs, grey.shape, max(gap, _GAP)) if spec.mask == "auto" else None
    found = Detector(spec, dark, rough.diameter_px, mask, edge)
    known = spec.diameter_px is not None and spec.polarity != "auto"
    if doubt and not known and not is_printed(found._fit(grey, _ROUNDS)[0], field):
        raise none
    return found


def to_grey(image: NDArray[Any], largest_mpx: float) -> NDArray[np.float32]:
    """Grey levels of an image.

    Parameters
    ----------
    image
        (h, w), (h, w, 1), (h, w, 3) or (h, w, 4) of any number type; colours in the order blue, green, red.
    largest_mpx
        Largest image that is taken, in millions of pixels.

    Returns
    -------
    ndarray
        (h, w) in the levels of the image; fractions up to 1 in levels up to 255.

    Raises
    ------
    PalpateError
        If it is no image, is smaller than 8 px, larger than allowed, or holds what is not a number.
    """
    image = np.asarray(image)
    colours = image.shape[2] if image.ndim == 3 else 1
    if image.ndim not in (2, 3) or colours not in (1, 3, 4) or image.dtype.kind not in "buif":
        raise PalpateError(
            f"An array of shape {image.shape} and type {image.dtype} is not an image.",
            "Give (h, w).",
            code="image-shape-wrong",
        )
    height, width = image.shape[:2]
    if min(height, width) < _SMALLEST_PX:
        raise PalpateError(
            f"The image has {width} × {height} px.",
            f"Give one of at least {_SMALLEST_PX} px a side.",
            code="image-too-small",
        )
    if height * width > largest_mpx * 1e6:
        raise PalpateError(
            f"The image has {width} × {height} px, more than {largest_mpx:g} million.",
            "Shrink it, or raise largest_mpx.",
            code="image-too-large",
        )
    if image.ndim == 3:
        image = image[..., 0] if colours == 1 else image[..., :3].astype(np.float32) @ _LUMA
    grey = np.ascontiguousarray(image, np.float32)
    if image.dtype.kind == "f" and not np.isfinite(grey).all():
        raise PalpateError(
            "The image holds values that are not numbers.", "Repair or leave it out.", code="image-not-finite"
        )
    # the detector's minimum noise is that of whole grey levels, so fractions are brought to those
    return grey * np.float32(255.0) if image.dtype.kind == "f" and 0.0 < grey.max(initial=0.0) <= 1.0 else grey


def inside(mask: BoolArray, points_px: FloatArray) -> BoolArray:
    """(n,) whether points lie in a mask."""
    column = np.clip(np.rint(points_px[:, 0]).astype(int), 0, mask.shape[1] - 1)
    row = np.clip(np.rint(points_px[:, 1]).astype(int), 0, mask.shape[0] - 1)
    return np.asarray(mask[row, column])


def _refine(
    raised: Image, segments: Segments, chosen: NDArray[np.intp], noise: float, fit: tuple[float, tuple[int, int]]
) -> tuple[Blobs, float]:
    """Blobs with centres fitted on the image, and the median blur of their edges."""
    labels = segments.labels
    spread = _calm(segments.spread[chosen], segments.contrast[chosen] / noise * np.sqrt(segments.area_px[chosen]))
    # a disc of the blob's area and axes
    scale = segments.area_px[chosen] / (4.0 * np.pi * np.sqrt(np.maximum(_determinant(spread), 1e-3)))
    start = np.column_stack([segments.middle_px[chosen], spread * scale[:, None]])
    fitted = fit_centres(raised, labels, (chosen + 1).astype(np.int32), start, *fit)
    good = np.isfinite(fitted[:, 0])
    fitted, start, chosen = fitted[good], start[good], chosen[good]
    diameter = 4.0 * _determinant(start[:, 2:]) ** 0.25 * fitted[:, 2]
    blobs = Blobs(
        positions_px=fitted[:, :2].copy(),
        diameter_px=diameter,
        contrast=fitted[:, 3].copy(),
        sigma_px=fitted[:, 5] * noise,
        at_border=segments.at_border[chosen],
        noise=noise,
    )
    return blobs, float(np.median(fitted[:, 4])) if len(fitted) else fit[0]


def _calm(spread: FloatArray, clarity: FloatArray) -> FloatArray:
    """Shapes drawn towards a circle where the noise would shape them (`clarity`: contrast over noise of the sum)."""
    weight = 1.0 / (1.0 + (clarity / _CLEAR) ** 2)
    middle = (spread[:, 0] + spread[:, 2]) / 2.0
    circle = np.stack([middle, np.zeros_like(middle), middle], axis=-1)
    return np.asarray(spread + weight[:, None] * (circle - spread))


def _determinant(spread: FloatArray) -> FloatArray:
    return np.asarray(spread[:, 0] * spread[:, 2] - spread[:, 1] ** 2)


def _find_mask(blobs: Blobs, shape: tuple[int, int], gap: float) -> BoolArray | None:
    """Where the largest group of neighbouring dots is, and one spacing more."""
    from scipy.spatial import cKDTree

    if len(blobs) < 4:
        return None
    tree = cKDTree(blobs.positions_px)
    spacing = float(np.median(tree.query(blobs.positions_px, 2)[0][:, 1]))
    pairs = tree.query_pairs(gap * spacing, output_type="ndarray")
    largest = largest_group(pairs, np.ones(len(blobs), bool))
    if largest.sum() < 4:
        return None
    return grow(fill_hull(blobs.positions_px[largest], shape), int(np.ceil(1.5 * spacing)))
