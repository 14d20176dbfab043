"""Light, sharpness and marker positions of one image of a sensor.

The blur of a marker's edge is measured along rays from its centre. With p = 1 on the marker and 0 on the skin, the
variance of the edge's slope is s² = 2 ∫ u p du - (∫ p du)². A motion of length L during the exposure adds L²/12 along
its direction, so the second harmonic of s² over the azimuth is L²/24 at twice the direction.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError, load_opencv
from palpate.rig.check_image import measure_exposure
from palpate.vision import Blobs, Detector


class ImageFigures(NamedTuple):
    """Measured properties of one image with n blobs.

    Attributes
    ----------
    blobs
        The blobs.
    saturated
        Share of the pixels of the field at the maximum grey value.
    light, brighter
        (n, c) grey value of the skin at each blob, by colour; (n,) that of the brighter of skin and marker, mean.
    edge_px
        Median blur (standard deviation) of the blobs' edges.
    harmonic
        (n,) second harmonic of s² over the azimuth, complex, px²; scaled by `edge_px`² over the median of s², since
        rays are too short for all of a blur.
    """

    blobs: Blobs
    saturated: float
    light: FloatArray
    brighter: FloatArray
    edge_px: float
    harmonic: NDArray[np.complex128]

    @property
    def looks(self) -> FloatArray:
        """Contrast over the light, and diameter in px, (2, n) of the blobs."""
        return np.stack([self.blobs.contrast / self.brighter, self.blobs.diameter_px])


def measure_image(image: NDArray[Any], detector: Detector, rays: int = 16, samples: int = 25) -> ImageFigures:
    """Measure an image (h, w) or (h, w, 3) of integers, on `rays` of some samples from each centre.

    Raises
    ------
    PalpateError
        If its size differs from that of the detector, or it has fewer than two blobs.
    """
    cv2, blobs = load_opencv(), detector.find(image)
    if len(blobs) < 2:
        raise PalpateError(f"The image has {len(blobs)} blobs.", "Check light and focus.", code="markers-not-found")
    layers = image.reshape(*image.shape[:2], -1).astype(np.float32)
    radius, azimuth = 0.5 * blobs.diameter_px, np.linspace(0.0, 2.0 * np.pi, rays, endpoint=False)
    half = np.clip(2.0 * detector.edge_px + 1.0, 2.0, np.maximum(radius, 2.0))[:, None, None]
    along, at = half * np.linspace(0.0, 2.0, samples), np.broadcast_to(radius[:, None, None], (len(blobs), rays, 1))
    for _ in range(2):  # the second time about the edge of each ray, since markers are ellipses
        distance = at - half + along
        column = blobs.positions_px[:, :1, None] + distance * np.cos(azimuth)[:, None]
        row = blobs.positions_px[:, 1:, None] + distance * np.sin(azimuth)[:, None]
        points = [axis.reshape(len(blobs), -1).astype(np.float32) for axis in (column, row)]
        seen = cv2.remap(layers, *points, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        profiles = np.reshape(seen, (*distance.shape, -1)).astype(float)
        inside, outside = (np.median(profiles[:, :, end], axis=1) for end in (0, -1))
        ground, height = (part.mean(axis=1)[:, None, None] for part in (outside, inside - outside))
        share = (profiles.mean(axis=-1) - ground) / np.where(abs(height) < 1.0, 1.0, height)
        first = np.trapezoid(share, along, axis=-1)
        at = at + np.clip(first[..., None] - half, -half, half)
    variance = 2.0 * np.trapezoid(along * share, along, axis=-1) - first**2
    edge, median = detector.measure_edge(image), float(np.median(variance.mean(axis=1)))
    full = np.asarray(layers.max(axis=2) >= measure_exposure(image).top)
    return ImageFigures(
        blobs,
        float(full[... if detector.mask is None else detector.mask].mean()),
        outside,
        np.maximum(outside.mean(axis=1) + (0.0 if detector.dark else blobs.contrast), 1.0),
        edge,
        2.0 * (variance * np.exp(2j * azimuth)).mean(axis=1) * (edge**2 / max(median, 0.5 * edge**2)),
    )
