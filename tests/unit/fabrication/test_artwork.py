"""The flat artwork of the pad print."""

import numpy as np
import pytest

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.design.flat_pad import FlatPadSpec
from palpate.fabrication import PadMapping, ProcessSpec, draw_artwork, project_to_page, project_to_skin

ANGLE = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
CIRCLE = np.column_stack([np.cos(ANGLE), np.sin(ANGLE)])


@pytest.mark.parametrize("mapping", PadMapping)
@pytest.mark.parametrize("height", [10, 20, 30])
def test_carry_to_dome_brings_every_dot_to_its_marker(mapping: PadMapping, height: float) -> None:
    dome = build_skin(DomeSpec(height=height))
    layout = place_markers(dome, MarkerSpec(count=169))
    artwork = draw_artwork(dome, layout, mapping)
    assert project_to_skin(dome, artwork.dots, mapping) == pytest.approx(layout.positions, abs=1e-9)


@pytest.mark.parametrize("mapping", PadMapping)
def test_the_artwork_of_a_flat_pad_is_carried_back_and_has_its_rim(mapping: PadMapping) -> None:
    pad = FlatPadSpec(height=3.5, base_radius=10.375, thickness=0.5, stretch=1.217, flat_radius=7.5).build()
    layout = place_markers(pad, MarkerSpec(ring_diameters=(6.0, 12.0, 18.0)))
    artwork = draw_artwork(pad, layout, mapping)
    assert project_to_skin(pad, artwork.dots, mapping) == pytest.approx(layout.positions, abs=1e-9)
    assert artwork.rim_line is not None
    most = np.abs(artwork.rim_line).max(axis=0)
    assert most[0] == pytest.approx(artwork.rim, rel=1e-3)
    assert artwork.crosses.max(axis=0) == pytest.approx(most + 6.0)
    if mapping is PadMapping.AXIS:
        assert most == pytest.approx([10.375, 1.217 * 10.375], rel=1e-4)
    assert draw_artwork(build_skin(DomeSpec()), layout, mapping).rim_line is None


@pytest.mark.parametrize("mapping", PadMapping)
@pytest.mark.parametrize("height", [10, 20, 30])
def test_dots_are_round_on_the_dome(mapping: PadMapping, height: float) -> None:
    """Points of the ellipses of the page, carried to the dome by the pad, lie on spheres about the markers."""
    dome = build_skin(DomeSpec(height=height))
    layout = place_markers(dome, MarkerSpec(count=169))
    artwork = draw_artwork(dome, layout, mapping)
    marks = [*layout.positions, place_orientation_mark(dome, layout)]
    for marker, (centre, axes) in zip(marks, artwork.ellipses, strict=True):
        outline = project_to_skin(dome, centre + CIRCLE @ axes, mapping)
        assert np.linalg.norm(outline - marker, axis=1) == pytest.approx(layout.diameter / 2, rel=0.06)
    slope = np.arccos(dome.normal(layout.positions)[:, 2]).max()
    flattest = (np.linalg.norm(artwork.axes[:, 1], axis=1) / np.linalg.norm(artwork.axes[:, 0], axis=1)).min()
    if mapping is PadMapping.AXIS:
        assert flattest == pytest.approx(np.cos(slope), rel=0.06), "a circle seen along the axis"


@pytest.mark.parametrize("count", [7, 37, 91, 169])
@pytest.mark.parametrize("height", [10, 15, 20, 30])
def test_the_mark_keeps_a_gap_to_the_dots(count: int, height: float) -> None:
    dome = build_skin(DomeSpec(height=height))
    layout = place_markers(dome, MarkerSpec(count=count))
    printed = draw_artwork(dome, layout, PadMapping.AXIS).ellipses
    outlines = np.array([centre + CIRCLE @ axes for centre, axes in printed])
    apart = np.linalg.norm(outlines[-1][:, None] - outlines[:-1].reshape(1, -1, 2), axis=-1)
    assert apart.min() >= ProcessSpec().min_gap


def test_flatten_by_arc_keeps_lengths_along_the_meridian() -> None:
    dome = build_skin(DomeSpec(height=20))
    points = dome.inner_point([0.0, 10.0, 20.0], [0.0, 0.0, 0.0])
    assert -project_to_page(dome, points, PadMapping.ARC)[:, 0] == pytest.approx(
        [0.0, 20 * np.pi / 6, 20 * np.pi / 2]
    )
    assert -project_to_page(dome, points, PadMapping.AXIS)[:, 0] == pytest.approx([0.0, 10.0, 20.0])


def test_the_page_shows_the_dome_from_its_base() -> None:
    dome = build_skin(DomeSpec())
    marker = dome.inner_point([10.0], [np.radians(30.0)])
    x, y = project_to_page(dome, marker, PadMapping.AXIS)[0]
    assert x == pytest.approx(-10 * np.cos(np.radians(30)))
    assert y == pytest.approx(5.0)


def test_draw_artwork_leaves_the_mark_out_when_asked() -> None:
    dome = build_skin(DomeSpec())
    layout = place_markers(dome, MarkerSpec(count=37))
    assert draw_artwork(dome, layout, PadMapping.AXIS, mark=False).mark is None
    assert draw_artwork(dome, layout, PadMapping.AXIS).mark is not None
