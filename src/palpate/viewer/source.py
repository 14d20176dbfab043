"""Where images come from: a folder of them, a video, a camera, or touches of a virtual unit of the design."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import RenderSpec, edge_offsets, list_images, read_image, render
from palpate.core import FloatArray, PalpateError, generator, load_extra
from palpate.design import Skin, place_orientation_mark
from palpate.viewer.library import Specimen
from palpate.viewer.markers_seen import follow_points
from palpate.viewer.results import Design

LARGEST_MPX = 20.0
SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".webp")
VIDEOS = (".avi", ".mp4", ".mkv", ".mov", ".webm")
_DEEPEST_SEARCH = 2
"""Folders below the result folder in which recordings are looked for."""
_EDGE = 14
"""Corners of a dot's edge: enough for its centre."""
_NOISE = 2.0
"""Standard deviation of a pixel of a virtual unit, grey levels."""
_DOWN, _HOLD, _UP = 14, 4, 7
"""Images of a touch as the wall goes down, stays and goes up."""


@dataclass(frozen=True, eq=False)
class Shot:
    """One image on its way to the sensor.

    Attributes
    ----------
    image
        (h, w) or (h, w, 3); or why it cannot be read.
    truth
        rx, ry (degrees) and depth (mm) where they are known.
    """

    image: NDArray[Any] | PalpateError
    truth: tuple[float, float, float] | None = None


def find_recordings(folder: Path) -> tuple[str, ...]:
    """Names of folders with images, and of videos, inside a result folder, relative to it; its store is left out."""
    found = []
    places = [(folder, 0)]
    while places:
        place, depth = places.pop()
        for path in sorted(place.iterdir()):
            if path.suffix.lower() in VIDEOS and path.is_file() and not path.is_symlink():
                found.append(str(path.relative_to(folder)))
            if path.is_symlink() or not path.is_dir() or path.name.startswith(".") or path == folder / "store":
                continue
            if any(item.suffix.lower() in SUFFIXES for item in path.iterdir()):
                found.append(str(path.relative_to(folder)))
            if depth + 1 < _DEEPEST_SEARCH:
                places.append((path, depth + 1))
    return tuple(sorted(found))


def inside(folder: Path, name: str) -> Path:
    """A folder or video inside a folder by its relative name.

    Raises
    ------
    PalpateError
        If it would lie outside, links followed, or is none.
    """
    root = folder.resolve()
    try:
        path = (root / name).resolve()
    except (OSError, ValueError, RuntimeError):
        path = root.parent
    known = path.is_dir() or (path.is_file() and path.suffix.lower() in VIDEOS)
    if path == root or not path.is_relative_to(root) or not known:
        raise PalpateError(f"There is no recording '{name[:60]}' in {folder.name}.", "Choose one from the list.")
    return path


def replay(recording: Path) -> Iterator[Shot]:
    """The images of a folder or video in order, each once; one that cannot be read is passed on as its error."""
    if recording.is_file():
        yield from capture(recording)
        return
    for path in list_images(recording):
        try:
            yield Shot(read_image(path, LARGEST_MPX))
        except PalpateError as error:
            yield Shot(error)


def capture(place: Path | int) -> Iterator[Shot]:
    """Images of a video, or of the camera of a number, as they come.

    Raises
    ------
    PalpateError
        If it cannot be opened.
    MissingExtraError
        If OpenCV is not installed.
    """
    cv2 = load_extra("cv2", "vision", "OpenCV")
    stream = cv2.VideoCapture(place if isinstance(place, int) else str(place))
    try:
        if not stream.isOpened():
            name = f"Camera {place}" if isinstance(place, int) else place.name
            raise PalpateError(f"{name} cannot be opened.", "Check that it is there and no other program uses it.")
        while True:
            taken, image = stream.read()
            if not taken:
                return
            yield Shot(image)
    finally:
        stream.release()


def touch_for_ever(design: Design, specimen: Specimen, seed: int = 0) -> Iterator[Shot]:
    """Touches of a virtual unit of a design by a wall of random tilt and azimuth; the first image is at rest.

    Needs OpenCV.
    """
    rng = generator(seed, "touches")
    light = RenderSpec(vignetting=0.2, blur_px=0.5, seed=seed)
    edges = _edges(design.dome, design)

    def look(points: FloatArray) -> NDArray[np.uint8]:
        image = render(design.camera, points, light)
        return np.clip(image + rng.normal(0.0, _NOISE, image.shape), 0, 255).astype(np.uint8)

    yield Shot(look(edges), (0.0, 0.0, 0.0))
    pressed = specimen.pressed
    first, last = float(pressed.tilts_deg[0]), float(pressed.tilts_deg[-1])
    while True:
        tilt, azimuth = float(rng.uniform(first, last)), float(rng.uniform(0.0, 360.0))
        motion = pressed.at(tilt)
        moved = follow_points(pressed.mesh, motion, edges.reshape(-1, 3), azimuth)
        deep = float(motion.depths_mm[-1]) * float(rng.uniform(0.6, 1.0))
        for depth in _depths(deep):
            place = float(np.interp(depth, motion.depths_mm, np.arange(len(moved))))
            low = min(int(place), max(len(moved) - 2, 0))
            high = min(low + 1, len(moved) - 1)
            points = moved[low] + (place - low) * (moved[high] - moved[low])
            angle = np.radians(azimuth)
            truth = (tilt * float(np.cos(angle)), tilt * float(np.sin(angle)), depth)
            yield Shot(look(points.reshape(edges.shape)), truth)


def _depths(deepest: float) -> list[float]:
    down, up = np.linspace(0.0, deepest, _DOWN), np.linspace(deepest, 0.0, _UP)
    return [float(depth) for depth in (*down, *([deepest] * _HOLD), *up)]


def _edges(dome: Skin, design: Design) -> FloatArray:
    """Edges (m + 1, k, 3) mm of the dots and of the orientation mark, on the undeformed inner surface."""
    mark = place_orientation_mark(dome, design.layout)
    centres = np.concatenate([design.layout.positions, mark[None]])
    normals = dome.normal(centres)
    aside = np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(normals, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normals, first)
    flat = edge_offsets(design.layout.diameter / 2, _EDGE)
    around = centres[:, None] + flat[:, :1] * first[:, None] + flat[:, 1:] * second[:, None]
    edges = dome.nearest(around)
    edges[..., 2] = np.maximum(edges[..., 2], 1e-6)  # a dot at the rim ends there
    return edges
