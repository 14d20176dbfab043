"""The orientation mark."""

import numpy as np
import pytest

from palpate.design import DomeSpec, EllipsoidSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.design.flat_pad import FlatPadSpec


@pytest.mark.parametrize("height", [10, 20, 30])
@pytest.mark.parametrize("count", [7, 37, 91, 169])
def test_place_orientation_mark_breaks_every_symmetry_and_touches_no_dot(height: float, count: int) -> None:
    dome = build_skin(DomeSpec(height=height))
    layout = place_markers(dome, MarkerSpec(count=count))
    mark = place_orientation_mark(dome, layout)
    assert dome.distance(mark) == pytest.approx(0.0, abs=1e-9)
    assert dome.distance_to_rim(mark[None])[0] > 0
    assert np.linalg.norm(layout.positions - mark, axis=1).min() > 1.1 * layout.diameter
    for turn in np.radians(60.0 * np.arange(1, 6)):
        turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ mark[:2]
        assert np.linalg.norm(turned - mark[:2]) > layout.diameter
    for axis in np.radians(30.0 * np.arange(12)):
        mirrored = 2 * (mark[:2] @ [np.cos(axis), np.sin(axis)]) * np.array([np.cos(axis), np.sin(axis)]) - mark[:2]
        assert np.linalg.norm(mirrored - mark[:2]) > layout.diameter


def test_mark_on_a_skin_that_bulges_is_still_beyond_the_outermost_ring() -> None:
    skin = build_skin(EllipsoidSpec(height=21.5, base_radius=16.0, thickness=2.15, aspect=0.6))
    layout = place_markers(skin, MarkerSpec(ring_diameters=(20.0, 32.57), diameter=1.0))
    mark = place_orientation_mark(skin, layout)
    assert np.hypot(*mark[:2]) >= 32.57 / 2 + 1.0


def test_the_mark_of_a_flat_pad_stays_on_it_where_rings_leave_little_room() -> None:
    pad = FlatPadSpec(height=3.5, base_radius=10.375, thickness=0.5, stretch=1.217, flat_radius=7.5).build()
    layout = place_markers(pad, MarkerSpec(ring_diameters=(6.0, 12.0, 18.0)))
    mark = place_orientation_mark(pad, layout)
    assert 9.0 < np.hypot(*mark[:2]) < pad.reach(np.radians(15.0))
    assert mark[2] > 0
