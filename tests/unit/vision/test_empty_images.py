"""An image without dots gives no field; one with dots gives the same dots as ever."""

from contextlib import suppress

import numpy as np
import pytest
from empty_images import KINDS, draw_empty

from palpate.camera import RenderSpec, build_camera, flat_marker_outlines, render
from palpate.core import PalpateError
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.vision import DetectSpec, prepare_detector

DOME = build_skin(DomeSpec())


def fields_of(kind: str, seeds: range) -> int:
    count = 0
    for seed in seeds:
        with suppress(PalpateError):
            prepare_detector(draw_empty(kind, seed))
            count += 1
    return count


@pytest.mark.parametrize("seeds", [range(2), pytest.param(range(2, 12), marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "cloth"])
def test_no_image_without_dots_gives_a_field(kind: str, seeds: range) -> None:
    assert fields_of(kind, seeds) == 0


@pytest.mark.slow
def test_few_weaves_give_a_field() -> None:
    """A weave that beats with the pixels is a field of like dots in order; some are still taken for print."""
    assert fields_of("cloth", range(20)) <= 4


def paint_dots(image: np.ndarray, spacing: float, radius: float, depth: float) -> tuple[np.ndarray, int]:
    """Dark discs in a square grid, painted pixel by pixel on 5 × 5 points within each."""
    fine = (np.arange(5) - 2) / 5
    y, x = np.mgrid[: image.shape[0], : image.shape[1]]
    half, last = spacing / 2, [60 + spacing * ((size - 121) // spacing) for size in image.shape]
    inside = (y > 60 - half) & (y < last[0] + half) & (x > 60 - half) & (x < last[1] + half)
    u, v = (x - 60 + half) % spacing - half, (y - 60 + half) % spacing - half
    covered = inside * np.mean([np.hypot(u + a, v + b) < radius for a in fine for b in fine], axis=0)
    count = int(np.prod([(end - 60) / spacing + 1 for end in last]))
    return np.clip(image - depth * covered, 0, 255).astype(np.uint8), count


@pytest.mark.parametrize("kind", ["gradient", "vignette"])
@pytest.mark.parametrize("depth", [60.0, 90.0])
def test_dots_painted_on_such_light_are_all_found(kind: str, depth: float) -> None:
    for seed in range(3):
        image, count = paint_dots(0.5 * draw_empty(kind, seed) + 110, 24.0, 5.0, depth)
        assert len(prepare_detector(image).find(image)) == count


@pytest.mark.parametrize("count", [7, 19, 37])
def test_the_dots_of_a_design_are_found_however_few(count: int) -> None:
    """Seven markers are a layout of the paper; whoever holds dots against a design need not doubt them."""
    layout = place_markers(DOME, MarkerSpec(count=count))
    edges = flat_marker_outlines(layout.positions, DOME.normal(layout.positions), layout.diameter)
    for seed in range(3):
        image = render(build_camera(), edges, RenderSpec(seed=seed))
        assert len(prepare_detector(image, doubt=count >= 8).find(image)) == count


def test_whoever_names_polarity_and_diameter_is_believed() -> None:
    image = np.full((200, 300), 180, np.uint8)
    y, x = np.mgrid[:200, :300]
    for cx, cy in ((80, 60), (150, 90), (210, 140), (90, 150)):
        image[np.hypot(x - cx, y - cy) < 6] = 60
    assert len(prepare_detector(image, DetectSpec(polarity="dark", diameter_px=12)).find(image)) == 4
