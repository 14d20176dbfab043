"""Marker detector with all settings determined."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.vision.centre import fit_centres
from palpate.vision.choose_field import choose_dots, choose_fields, is_printed
from palpate.vision.neighbours import largest_group
from palpate.vision.opencv import fill_hull, grow, simple_blobs
from palpate.vision.segment import Blobs, Segments, heights, measure_noise, segment
from palpate.vision.spec import DetectSpec
from palpate.vision.split import split_merged
from palpate.vision.stray_blobs import find_strays

Image = NDArray[np.float32]
_ROUNDS, _ROUNDS_TO_MEASURE = (1, 1), (8, 0)
"""Steps with free, and with fixed size and blur: in each image, and once to measure the blur. By hand."""
_EDGE_PX = 0.8
"""Initial blur of an edge: pixel width and a lens in focus. By hand."""
_GAP = 2.6
"""Minimum gap between markers of one field, over the median nearest-neighbour distance. By hand."""
_CLEAR = 40.0
"""Ratio of a blob's summed contrast to its noise at which half of its elongation is used. By hand."""
_CORRELATED = 1.5
"""Minimum noise at three pixels over that at one of an image whose noise is correlated.

White noise has 1.1, noise saved as JPEG of quality 80 has 7. By hand.
"""
_LUMA = np.array([0.114, 0.587, 0.299], np.float32)
"""Weights of blue, green and red (ITU-R BT.601), in OpenCV's order."""
_SMALLEST_PX = 8
"""Minimum side length of an image. By hand."""


@dataclass(frozen=True, eq=False)
class Detector:
    """Detector of markers of one polarity and size inside a mask.

    Attributes
    ----------
    spec
        Settings.
    dark
        Whether markers are darker than their surroundings.
    diameter_px
        Diameter of a marker.
    mask
        (h, w) searched region; `None` for the whole image.
    edge_px
        Blur of a marker's edge, by lens and pixel.
    drop_strays
        Whether blobs outside the field of markers, such as those of a rim, are left out.
    """

    spec: DetectSpec
    dark: bool
    diameter_px: float
    mask: BoolArray | None
    edge_px: float = _EDGE_PX
    drop_strays: bool = False

    def find(self, image: NDArray[Any]) -> Blobs:
        """Detect the blobs of an image (h, w) or (h, w, 3), of any number type.

        Raises
        ------
        PalpateError
            If it is not an image, is too small or too large, or differs in size from the mask.
        """
        grey = to_grey(image, self.spec.largest_mpx)
        if self.mask is not None and self.mask.shape != grey.shape:
            raise PalpateError(
                f"The image has {grey.shape[1]} × {grey.shape[0]} px, but the detector is for "
                f"{self.mask.shape[1]} × {self.mask.shape[0]}.",
                "Prepare a detector from an image of this size.",
                code="image-size-changed",
            )
        blobs = self._by_opencv(grey) if self.spec.method == "opencv" else self._fit(grey, _ROUNDS)[0]
        return blobs.take(~find_strays(blobs.positions_px, blobs.diameter_px)) if self.drop_strays else blobs

    def measure_edge(self, image: NDArray[Any]) -> float:
        """Return the median blur of the edges of blobs in an image (h, w) or (h, w, 3), px."""
        return self._fit(to_grey(image, self.spec.largest_mpx), _ROUNDS_TO_MEASURE)[1]

    @cached_property
    def _window(self) -> tuple[slice, slice]:
        """Rows and columns of the mask's bounding box, to which the search is limited."""
        if self.mask is None:
            return slice(None), slice(None)
        rows, columns = np.flatnonzero(self.mask.any(axis=1)), np.flatnonzero(self.mask.any(axis=0))
        return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)

    def _within(self, points_px: FloatArray) -> BoolArray:
        return np.ones(len(points_px), bool) if self.mask is None else inside(self.mask, points_px)

    def _fit(self, grey: Image, rounds: tuple[int, int]) -> tuple[Blobs, float]:
        """Return the blobs, and the median blur of their edges."""
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
    """Determine polarity, size and mask from an image, unless the spec gives them.

    Parameters
    ----------
    image
        (h, w) or (h, w, 3), any number type.
    spec
        Known properties of the markers.
    doubt
        Whether blobs that do not look printed, such as lamps and grain, and blobs of a rim are rejected; `False` if
        they are compared with a design later.
    gap
        Maximum gap between markers of one field, over the median distance of nearest neighbours; at least 2.6.
        Anything further away is masked.

    Raises
    ------
    PalpateError
        If no field of markers is found. With given polarity and diameter, blobs need not look printed.
    """
    spec = spec or DetectSpec()
    grey = to_grey(image, spec.largest_mpx)
    found = _prepare(grey, spec, doubt, gap)
    if found is None and (correlated := measure_noise(grey, 3) / measure_noise(grey)) > _CORRELATED:
        spec = spec.model_copy(update={"threshold": min(correlated * spec.threshold, 100.0)})
        found = _prepare(grey, spec, doubt, gap)
    if found is None:
        raise PalpateError(
            f"No field of markers was found in the image (grey levels {grey.min():g} to {grey.max():g}).",
            "Check light and focus. `palpate sensor detect --polarity … --diameter …` tests other settings.",
            code="markers-not-found",
        )
    return found


def _prepare(grey: Image, spec: DetectSpec, doubt: bool, gap: float) -> Detector | None:
    """Return the detector of the first field in grey levels (h, w) that looks printed, or `None`."""
    known = spec.diameter_px is not None and spec.polarity != "auto"
    for field in choose_fields(grey, spec):
        rough = Detector(spec, field.dark, spec.diameter_px or field.diameter_px, None)
        blobs, edge = rough._fit(grey, _ROUNDS_TO_MEASURE)
        mask = _find_mask(blobs, grey.shape, max(gap, _GAP)) if spec.mask == "auto" else None
        found = Detector(spec, field.dark, rough.diameter_px, mask, edge, doubt)
        if not doubt or known or is_printed(found._fit(grey, _ROUNDS)[0], field):
            return found
    return None


def to_grey(image: NDArray[Any], largest_mpx: float) -> NDArray[np.float32]:
    """Convert an image to grey levels (h, w); fractions up to 1 are scaled to 255.

    The image is (h, w), (h, w, 1), (h, w, 3) or (h, w, 4) of any number type, colours in the order blue, green, red,
    and has at most `largest_mpx` million pixels.

    Raises
    ------
    PalpateError
        If it is not an image, is smaller than 8 px, larger than allowed, or contains values that are not finite.
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
            "Reduce it, or increase largest_mpx.",
            code="image-too-large",
        )
    if image.ndim == 3:
        image = image[..., 0] if colours == 1 else image[..., :3].astype(np.float32) @ _LUMA
    grey = np.ascontiguousarray(image, np.float32)
    if image.dtype.kind == "f" and not np.isfinite(grey).all():
        raise PalpateError(
            "The image contains values that are not finite.", "Repair or omit it.", code="image-not-finite"
        )
    # the detector's minimum noise is that of whole grey levels, so fractions are brought to those
    return grey * np.float32(255.0) if image.dtype.kind == "f" and 0.0 < grey.max(initial=0.0) <= 1.0 else grey


def inside(mask: BoolArray, points_px: FloatArray) -> BoolArray:
    """Return whether points lie in a mask (n,)."""
    column = np.clip(np.rint(points_px[:, 0]).astype(int), 0, mask.shape[1] - 1)
    row = np.clip(np.rint(points_px[:, 1]).astype(int), 0, mask.shape[0] - 1)
    return np.asarray(mask[row, column])


def _refine(
    raised: Image, segments: Segments, chosen: NDArray[np.intp], noise: float, fit: tuple[float, tuple[int, int]]
) -> tuple[Blobs, float]:
    """Fit the centres of blobs on the image; return them and the median blur of their edges."""
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
    """Blend shapes with a circle by their noise (`clarity`: summed contrast over its noise)."""
    weight = 1.0 / (1.0 + (clarity / _CLEAR) ** 2)
    middle = (spread[:, 0] + spread[:, 2]) / 2.0
    circle = np.stack([middle, np.zeros_like(middle), middle], axis=-1)
    return np.asarray(spread + weight[:, None] * (circle - spread))


def _determinant(spread: FloatArray) -> FloatArray:
    return np.asarray(spread[:, 0] * spread[:, 2] - spread[:, 1] ** 2)


def _find_mask(blobs: Blobs, shape: tuple[int, int], gap: float) -> BoolArray | None:
    """Return a mask of the largest group of neighbouring blobs, with a margin of 1.5 spacings."""
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
