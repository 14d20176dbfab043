"""Functions of OpenCV, 4.10 to 5, used for detection: filters, components, blob detector."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, load_opencv

Image = NDArray[np.float32]


def blur(image: Image, sigma_px: float) -> Image:
    """Blur an image by a Gaussian; borders are mirrored."""
    return np.asarray(load_opencv().GaussianBlur(image, (0, 0), sigma_px), np.float32)


def box(image: Image, size_px: int) -> Image:
    """Return the mean over a square."""
    return np.asarray(load_opencv().blur(image, (size_px, size_px)), np.float32)


def close(image: Image, size_px: int) -> Image:
    """Return the grey closing by a square, which fills darker areas narrower than it."""
    cv2 = load_opencv()
    kernel = cv2.getStructuringElement(cv2.MORPH_RECT, (size_px, size_px))
    return np.asarray(cv2.morphologyEx(image, cv2.MORPH_CLOSE, kernel), np.float32)


def local_maxima(image: Image, size_px: int) -> BoolArray:
    """Return the pixels that are the maximum of the square around them."""
    return np.asarray(image >= dilate(image, size_px))


def dilate(image: Image, size_px: int) -> Image:
    """Return the maximum of the square around each pixel."""
    cv2 = load_opencv()
    kernel = cv2.getStructuringElement(cv2.MORPH_RECT, (size_px, size_px))
    return np.asarray(cv2.dilate(image, kernel), np.float32)


def components(mask: BoolArray) -> tuple[int, NDArray[np.int32]]:
    """Return the number of 8-connected components and labels (h, w), 0 outside them."""
    count, labels = load_opencv().connectedComponents(mask.astype(np.uint8), connectivity=8, ltype=4)
    return int(count) - 1, np.asarray(labels, np.int32)


def grow(mask: BoolArray, margin_px: int) -> BoolArray:
    """Expand a mask by a margin."""
    cv2 = load_opencv()
    size = 2 * margin_px + 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    return np.asarray(cv2.dilate(mask.astype(np.uint8), kernel)) > 0


def fill_hull(points_px: FloatArray, shape: tuple[int, int]) -> BoolArray:
    """Return a mask of the convex hull of points (n, 2), n ≥ 3."""
    cv2 = load_opencv()
    mask = np.zeros(shape, np.uint8)
    hull = cv2.convexHull(np.rint(points_px).astype(np.int32).reshape(-1, 1, 2))
    cv2.fillConvexPoly(mask, hull, 1)
    return mask > 0


def simple_blobs(image: NDArray[np.uint8], diameter_px: float, dark: bool) -> FloatArray:
    """Detect centres and diameters (n, 3) by OpenCV's `SimpleBlobDetector`."""
    cv2 = load_opencv()
    spec = cv2.SimpleBlobDetector_Params()
    area = np.pi / 4 * diameter_px**2
    spec.filterByColor, spec.blobColor = True, 0 if dark else 255
    spec.filterByArea, spec.minArea, spec.maxArea = True, float(area / 3), float(3 * area)
    spec.filterByConvexity, spec.filterByInertia, spec.filterByCircularity = False, True, False
    spec.minInertiaRatio = 0.2
    spec.minDistBetweenBlobs = float(max(0.8 * diameter_px, 1.0))
    spec.minThreshold, spec.maxThreshold, spec.thresholdStep, spec.minRepeatability = 10.0, 245.0, 5.0, 3
    found = cv2.SimpleBlobDetector_create(spec).detect(image)
    return np.array([[*point.pt, point.size] for point in found], float).reshape(-1, 3)
