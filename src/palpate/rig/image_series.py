"""Figures of a series of images of one sensor: light, sharpness, and common motion of the markers."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.core import FloatArray, PalpateError
from palpate.rig.check_image import Exposure, measure_exposure
from palpate.rig.measure_image import ImageFigures, measure_image
from palpate.vision import Detector, DetectSpec, prepare_detector

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOTION_VARIANCE = 1.0 / 24.0
"""Mean and second harmonic over the azimuth of the variance by a motion, over its squared length."""


@dataclass(eq=False)
class ImageSeries:
    """Measured images of one sensor; `read` adds images.

    Attributes
    ----------
    detect, detector, shape
        Known properties of the markers; detector of the first image with markers; shape of all images.
    figures
        Figures of the images in which markers were detected.
    unreadable, repeated
        Number of images without the markers of the first, and that equal the one before.
    exposures, light
        Exposure of each readable image, and grey value that few of its pixels exceed.
    last, faint
        The last readable image; figures of the first one with fainter blobs, of a rim, too.
    """

    detect: DetectSpec
    detector: Detector | None = None
    shape: tuple[int, ...] | None = None
    figures: list[ImageFigures] = field(default_factory=list)
    unreadable: int = 0
    repeated: int = 0
    exposures: list[Exposure] = field(default_factory=list)
    light: list[float] = field(default_factory=list)
    last: NDArray[Any] | None = None
    faint: ImageFigures | None = None

    def read(self, images: Iterable[NDArray[Any] | PalpateError], bright: float = 0.95, attempts: int = 10) -> None:
        """Measure images one by one, and store none but the last; their light is the quantile `bright`.

        The detector is prepared in some attempts. Images of another shape, smaller than 8 px, or with less than half
        of the first one's markers are left out.
        """
        for image in images:
            if isinstance(image, PalpateError) or not np.issubdtype(image.dtype, np.integer):
                self.unreadable += 1
                continue
            image = image[..., :3] if image.ndim > 2 else image
            if min(image.shape[:2]) < 8 or image.shape != (self.shape or image.shape):
                self.unreadable += 1
                continue
            self.shape = image.shape
            self.repeated += self.last is not None and np.array_equal(image, self.last)
            self.last = image
            self.exposures.append(measure_exposure(image))
            self.light.append(float(np.quantile(image, bright)))
            if self.detector is None and len(self.exposures) <= attempts:
                with suppress(PalpateError):
                    self._prepare(image)
            if self.detector is None:
                continue
            count = len(self.figures)
            with suppress(PalpateError):
                found = measure_image(image, self.detector)
                if count == 0 or 2 * len(found.blobs) >= len(self.figures[0].blobs):
                    self.figures.append(found)
            self.unreadable += len(self.figures) == count

    def _prepare(self, image: NDArray[Any], faint: float = 0.05) -> None:
        """Prepare the detector, and measure blobs of down to a `faint` share of the typical contrast."""
        low = self.detect.model_copy(update={"threshold": max(0.5 * self.detect.threshold, 2.0)})
        try:
            detector = prepare_detector(image, self.detect)
        except PalpateError:
            detector = prepare_detector(image, low)
        self.detector = replace(detector, edge_px=detector.measure_edge(image))
        wide = replace(self.detector, spec=low.model_copy(update={"evenness": faint}), drop_strays=False)
        self.faint = measure_image(image, wide)

    @cached_property
    def top(self) -> float:
        """Maximum grey value of the camera."""
        return max(one.top for one in self.exposures)

    @cached_property
    def _matched(self) -> tuple[FloatArray, FloatArray]:
        """Positions (k, m, 2) and light (k, m, c) in k images of the m markers that are in all of them."""
        first = self.figures[0].blobs.positions_px
        reach = 0.5 * float(np.median(cKDTree(first).query(first, 2)[0][:, 1]))
        before, kept, places, lights = first, np.ones(len(first), bool), [], []
        for one in self.figures:
            distance, number = cKDTree(one.blobs.positions_px).query(before, distance_upper_bound=reach)
            kept &= np.isfinite(distance)
            number = np.minimum(number, len(one.blobs) - 1)
            before = np.where(np.isfinite(distance)[:, None], one.blobs.positions_px[number], before)
            places.append(before)
            lights.append(one.light[number])
        kept |= kept.sum() < 2
        return np.array(places)[:, kept], np.maximum(np.array(lights)[:, kept], 1.0)

    @cached_property
    def motion(self) -> tuple[FloatArray, float]:
        """Shift and rms motion by rotation and scale (k, 4), px; noise of a marker coordinate, px."""
        z = self._matched[0] @ [1.0, 1j]
        kept = np.ones(z.shape[1], bool)
        for _ in range(2):
            centre = z[:, kept].mean(axis=1, keepdims=True)
            start = (z - centre).mean(axis=0)
            size = float(np.sqrt((abs(start[kept]) ** 2).mean()))
            factor = (z - centre)[:, kept] @ start[kept].conj() / (abs(start[kept]) ** 2).sum()
            left = z - centre - factor[:, None] * start
            spread = (abs(left - left.mean(axis=0)) ** 2).sum(axis=0)
            kept = np.sqrt(spread) <= 2.0 * np.sqrt(np.median(spread))  # without markers that come and go
        shift = centre[:, 0] - centre.mean()
        noise = float(np.sqrt(np.median(spread) / max(len(z) - 1, 1) / 2.0))
        return np.stack([shift.real, shift.imag, size * factor.imag, size * (factor.real - 1.0)], axis=1), noise

    @cached_property
    def brightness(self) -> FloatArray:
        """Light (k, c) of each image over the mean of the series, by colour: median over markers."""
        light = self._matched[1]
        return np.asarray(np.median(light / light.mean(axis=0), axis=1))

    def light_ratio(self, image: ImageFigures) -> FloatArray:
        """Light (n, c) at the blobs of another image over that of the nearest markers of the series."""
        places, lights = self._matched
        nearest = cKDTree(places.mean(axis=0)).query(image.blobs.positions_px)[1]
        return np.asarray(np.maximum(image.light, 1.0) / lights.mean(axis=0)[nearest])

    @property
    def edge_px(self) -> FloatArray:
        """Blur (k,) of the markers' edges in each image, px."""
        return np.array([one.edge_px for one in self.figures])

    def motion_blur(self, rest: ImageSeries | None = None) -> float:
        """Length of the motion during an exposure, px, common or, beyond that at `rest`, radial.

        A press moves markers from the centre of the field; lenses may blur radially, too.
        """
        means = [_robust_mean(one.harmonic) for one in self.figures]
        common = np.sqrt(max(float(np.mean([abs(mean) ** 2 - noise for mean, noise in means])), 0.0))
        radial = self._radial - rest._radial if rest is not None else 0.0
        return float(np.sqrt(max(common, radial) / MOTION_VARIANCE))

    @cached_property
    def _radial(self) -> float:
        """Second harmonic of the blur along the direction from the centre of the field, px²."""
        parts = []
        for one in self.figures:
            z = (one.blobs.positions_px - np.median(one.blobs.positions_px, axis=0)) @ [1.0, 1j]
            parts.append(_robust_mean(one.harmonic * (z.conj() / np.maximum(abs(z), 1.0)) ** 2)[0].real)
        return float(np.mean(parts))

    def draw(self) -> Figure:
        """Draw the last image with its blobs, and light, blur and motion of the images."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10.0, 6.0), layout="constrained")
        axes = figure.subplot_mosaic([["image", "light / mean"], ["image", "blur, px"], ["image", "motion, px"]])
        if self.last is not None:
            grey = self.last if self.last.ndim == 2 else self.last.mean(axis=2)
            axes["image"].imshow(grey, cmap="gray", vmin=0.0, vmax=self.top)
        axes["image"].set(title="last image at rest, with blobs", xticks=[], yticks=[])
        if self.figures:
            axes["image"].plot(*self.figures[-1].blobs.positions_px.T, "+", color="#d1622b", ms=4)
            axes["light / mean"].plot(self.brightness, ".-")
            axes["blur, px"].plot(self.edge_px, ".-")
            axes["motion, px"].plot(self.motion[0], ".-", label=("column", "row", "rotation", "scale"))
            axes["motion, px"].legend(fontsize=8)
        for name, axis in axes.items():
            axis.set_ylabel("" if name == "image" else name)
        return figure


def _robust_mean(values: NDArray[np.complex128]) -> tuple[complex, float]:
    """Return the mean of values (n,) without outliers, such as blobs of a rim, and its variance."""
    distance = abs(values - (np.median(values.real) + 1j * np.median(values.imag)))
    kept = values[distance <= 2.0 * np.median(distance)]
    return complex(kept.mean()), float(kept.var() / len(kept))
