"""Events of an event camera, against what the light did."""

import numpy as np
import pytest

from errors import refused
from palpate.camera import EventSpec, build_camera, flat_marker_outlines, render, stream_events
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers

EVEN = EventSpec(threshold=0.1, spread=0.0, dark=1.0)


def grey(value, size=(4, 6)):
    return np.full(size, value, float)


def test_a_pixel_sends_an_event_for_every_step_of_log_light():
    levels = [np.exp(4.0) - 1.0, np.exp(4.35) - 1.0]
    (events,) = stream_events([grey(v) for v in levels], [0.0, 0.7], EVEN)
    assert len(events) == 3 * 24
    assert events.brighter.all()
    assert np.allclose(np.unique(events.time.round(9)), [0.2, 0.4, 0.6])


def test_what_is_left_of_a_step_is_kept_and_the_way_back_takes_it_off():
    levels = [np.exp(v) - 1.0 for v in (4.0, 4.06, 4.12, 4.03)]
    first, second, third = stream_events([grey(v, (1, 1)) for v in levels], [0, 1, 2, 3], EVEN)
    assert (len(first), len(second), len(third)) == (0, 1, 0)
    assert second.time[0] == pytest.approx(1 + (0.1 - 0.06) / 0.06)


def test_events_add_up_to_the_change_of_the_image():
    dome = build_skin(DomeSpec())
    layout = place_markers(dome, MarkerSpec(count=37))
    normals = (layout.positions - [0, 0, dome.center_z]) / dome.radius
    images = [
        render(
            build_camera(), flat_marker_outlines(layout.positions - np.array([0, 0, depth]), normals, layout.diameter)
        )
        for depth in (0.0, 0.4, 0.8)
    ]
    spec = EventSpec(spread=0.0)
    total = np.zeros((260, 346))
    for events in stream_events(images, [0.0, 0.1, 0.2], spec):
        assert (np.diff(events.time) >= 0).all()
        np.add.at(total, (events.row, events.column), np.where(events.brighter, 1, -1) * spec.threshold)
    change = np.log(images[2] + spec.dark) - np.log(images[0] + spec.dark)
    assert np.abs(total - change).max() < spec.threshold
    assert (total != 0).sum() > 500


def test_a_blind_pixel_sends_nothing():
    levels = [np.exp(4.0) - 1.0, np.exp(5.05) - 1.0]
    blind = EVEN.model_copy(update={"dead_time": 0.25})
    (events,) = stream_events([grey(v, (1, 1)) for v in levels], [0.0, 1.05], blind)
    assert np.allclose(events.time, [0.1, 0.4, 0.7, 1.0])


def test_images_of_one_size_at_rising_times_are_asked_for():
    with refused("events-image-order"):
        list(stream_events([grey(1), grey(2, (3, 3))], [0, 1]))
    with refused("events-image-order"):
        list(stream_events([grey(1), grey(2)], [1, 1]))
