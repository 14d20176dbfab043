"""Rendered images of the inside of a skin: markers on the deformed surface, and typical image defects.

Each marker is an outline on the surface, projected, and filled on a grid 8 times finer than the pixels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate.camera.camera import Camera
from palpate.core import FloatArray, Spec, load_opencv, parameter

SUPERSAMPLING = 8
"""Samples along each side of a pixel: 64 grey levels of an edge."""


class RenderSpec(Spec):
    """Light, lens and sensor of a rendered image; the defaults have no defects."""

    ground: float = parameter(200.0, unit="1", meaning="grey level of the skin at the brightest place", ge=0, le=255)
    dot: float = parameter(60.0, unit="1", meaning="grey level of a marker in the same light", ge=0, le=255)
    vignetting: float = parameter(0.0, unit="1", meaning="share of light lost in the image's corners", ge=0, le=0.95)
    unevenness: float = parameter(
        0.0, unit="1", meaning="relative decrease of the light across the image", ge=0, le=0.95
    )
    glare: float = parameter(0.0, unit="1", meaning="grey levels of the brightest of three reflections", ge=0, le=255)
    blur_px: float = parameter(0.0, unit="px", meaning="standard deviation of the lens blur", ge=0, le=20)
    noise: float = parameter(0.0, unit="1", meaning="standard deviation of a pixel, grey levels", ge=0, le=100)
    dirt: int = parameter(0, unit="1", meaning="number of specks of dirt on the skin", ge=0, le=1000)
    rim: bool = False
    """Whether a bright rim and dark clutter are visible outside the skin."""
    seed: int = parameter(0, unit="1", meaning="seed of light, dirt and noise", ge=0)
    noise_seed: int | None = parameter(
        None, unit="1", meaning="seed of the noise alone, with unchanged light and dirt; empty: as seed", ge=0
    )


def render(camera: Camera, edges: FloatArray, spec: RenderSpec | None = None) -> NDArray[np.uint8]:
    """Render the markers as the camera sees them, as (h, w) grey levels.

    Parameters
    ----------
    camera
        The camera.
    edges
        (m, k, 3) mm, outlines of the markers on the deformed surface, in the skin's frame.
    spec
        Light, lens and sensor.

    Examples
    --------
    >>> from palpate.camera import build_camera, flat_marker_outlines
    >>> edges = flat_marker_outlines(np.array([[0.0, 0.0, 20.0]]), np.array([[0.0, 0.0, 1.0]]), diameter=2.0)
    >>> image = render(build_camera(), edges)
    >>> image.shape, image.dtype
    ((260, 346), dtype('uint8'))
    """
    spec = spec or RenderSpec()
    cv2 = load_opencv()
    rng = np.random.default_rng(spec.seed)
    cover = _cover(camera, edges)
    y, x = np.mgrid[: camera.height_px, : camera.width_px].astype(float)
    u, v = (x - camera.width_px / 2) / camera.width_px, (y - camera.height_px / 2) / camera.height_px
    way = rng.uniform(0.0, 2.0 * np.pi)
    light = 1.0 - spec.vignetting * np.minimum((u**2 + v**2) * 2.0, 1.0)
    light *= 1.0 - spec.unevenness * np.clip(0.5 + u * np.cos(way) + v * np.sin(way), 0.0, 1.0)
    for _ in range(spec.dirt):
        _add_speck(cover, rng)
    image = light * (spec.ground + (spec.dot - spec.ground) * cover)
    if spec.rim:
        image = _add_rim(image, camera, edges, rng)
    if spec.blur_px:
        image = cv2.GaussianBlur(image, (0, 0), spec.blur_px)
    for share in (1.0, 0.6, 0.4) if spec.glare else ():
        place, width = rng.uniform(-0.35, 0.35, 2), rng.uniform(0.02, 0.05)
        image = image + share * spec.glare * np.exp(-((u - place[0]) ** 2 + (v - place[1]) ** 2) / (2.0 * width**2))
    if spec.noise:
        rng = rng if spec.noise_seed is None else np.random.default_rng(spec.noise_seed)
        image = image + rng.normal(0.0, spec.noise, image.shape)
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def _cover(camera: Camera, edges: FloatArray) -> FloatArray:
    """Return the share (h, w) of each pixel that markers cover, from a grid 8 times finer."""
    cv2 = load_opencv()
    pixels = camera.project(edges)
    fine = np.zeros((camera.height_px * SUPERSAMPLING, camera.width_px * SUPERSAMPLING), np.uint8)
    corners = (pixels + 0.5) * SUPERSAMPLING - 0.5
    near = np.isfinite(corners).all(axis=(1, 2)) & (np.abs(corners).max(axis=(1, 2)) < 2**20)
    for dot in corners[near]:
        _fill(fine, dot)
    size = (camera.width_px, camera.height_px)
    return np.asarray(cv2.resize(fine, size, interpolation=cv2.INTER_AREA), float) / 255.0


def _fill(fine: NDArray[np.uint8], points: FloatArray) -> None:
    """Fill fine pixels with their centre in a polygon; OpenCV's function also fills those cut by an edge."""
    low = np.maximum(np.floor(points.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(points.max(axis=0)).astype(int) + 1, np.array(fine.shape)[::-1])
    if np.any(high <= low):
        return
    x, y = np.arange(low[0], high[0]), np.arange(low[1], high[1])[:, None]
    (ax, ay), (bx, by) = points.T, np.roll(points, -1, axis=0).T
    rise = np.where(by == ay, 1.0, by - ay)
    crosses = (ay > y) != (by > y)
    across = np.sort(np.where(crosses, (bx - ax) * (y - ay) / rise + ax, -np.inf), axis=1)
    most = int(crosses.sum(axis=1).max(initial=0))  # edges that a row meets, two for a convex outline
    inside = (x < across[:, across.shape[1] - most :, None]).sum(axis=1) % 2 == 1
    fine[low[1] : high[1], low[0] : high[0]][inside] = 255


def _add_speck(cover: FloatArray, rng: np.random.Generator) -> None:
    height, width = cover.shape
    column, row, size = rng.integers(width), rng.integers(height), rng.uniform(0.4, 1.0)
    y, x = np.mgrid[max(row - 3, 0) : row + 4, max(column - 3, 0) : column + 4]
    y, x = np.minimum(y, height - 1), np.minimum(x, width - 1)
    cover[y, x] = np.maximum(cover[y, x], 0.5 * np.exp(-((x - column) ** 2 + (y - row) ** 2) / (2 * size**2)))


def _add_rim(image: FloatArray, camera: Camera, edges: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Add a bright ring around the markers and dark shapes outside it."""
    pixels = camera.project(edges).reshape(-1, 2)
    middle = np.nanmean(pixels, axis=0)
    reach = float(np.nanmax(np.linalg.norm(pixels - middle, axis=1)))
    y, x = np.mgrid[: camera.height_px, : camera.width_px].astype(float)
    radius = np.hypot(x - middle[0], y - middle[1])
    outside = radius > 1.08 * reach
    result = np.where(outside, 40.0, image)
    result = np.where(outside & (radius < 1.14 * reach), 250.0, result)
    for _ in range(8):
        way, far, size = rng.uniform(0, 2 * np.pi), rng.uniform(1.2, 1.7) * reach, rng.uniform(2, 8)
        place = middle + far * np.array([np.cos(way), np.sin(way)])
        low = np.clip(place - size - 1.0, 0, x.shape[::-1]).astype(int)
        high = np.clip(place + size + 2.0, 0, x.shape[::-1]).astype(int)
        box = slice(low[1], high[1]), slice(low[0], high[0])  # pixels that a shape can reach
        near = np.hypot(x[box] - middle[0] - far * np.cos(way), y[box] - middle[1] - far * np.sin(way)) < size
        result[box][near & outside[box]] = rng.uniform(0, 255)
    return np.asarray(result)
