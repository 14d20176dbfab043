import numpy as np
import pytest
from drawn_dots import draw_dots
from posed_dome import pressed, project

from errors import refused
from palpate.core import generator
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.vision import (
    MotionModel,
    Tracker,
    assign_markers,
    build_pattern,
    find_markers,
    fit_motion_model,
    prepare_detector,
)

DEPTHS = np.arange(0.0, 8.01, 0.8)


def markers(count):
    return place_markers(build_skin(DomeSpec()), MarkerSpec(count=count)).positions


def follow(tracker, images, rng, lost=0.02):
    """Steps through images with lost dots: number of swaps, errors of the estimates, flags of jumps."""
    swaps, errors, jumped = 0, [], []
    for pixels in images:
        seen = np.flatnonzero(rng.random(len(pixels)) >= lost)
        seen = rng.permutation(seen)
        sighting = tracker.step(pixels[seen] + rng.normal(0, 0.05, (len(seen), 2)))
        found = sighting.found
        swaps += int((seen[sighting.blob[found]] != np.flatnonzero(found)).sum())
        assert set(seen) == set(np.flatnonzero(found))
        errors += list(np.linalg.norm(sighting.positions_px - pixels, axis=1)[~found])
        jumped.append(sighting.jumped)
    return swaps, np.array(errors), jumped


@pytest.mark.parametrize("count", [7, 37, 91, 169])
def test_every_marker_keeps_its_number_through_a_press(count):
    images = [project(pressed(markers(count), depth)) for depth in DEPTHS]
    for draw in range(10):
        swaps, errors, jumped = follow(Tracker(MotionModel(images[0])), images, generator(draw, "track", count))
        assert swaps == 0
        assert not any(jumped)
        if count >= 91 and len(errors):
            assert np.median(errors) < 0.5
            assert errors.max() < 2.5


def test_a_lost_marker_comes_back_with_its_number():
    images = [project(pressed(markers(91), depth)) for depth in DEPTHS]
    tracker = Tracker(MotionModel(images[0]))
    for number, pixels in enumerate(images):
        gone = [5, 20, 60] if 2 <= number <= 8 else []
        seen = np.setdiff1d(np.arange(91), gone)
        sighting = tracker.step(pixels[seen])
        assert np.flatnonzero(~sighting.found).tolist() == gone
        assert (seen[sighting.blob[sighting.found]] == np.flatnonzero(sighting.found)).all()


def test_modes_learnt_from_presses_estimate_lost_markers_better():
    rest = markers(91)
    images = np.stack(
        [project(pressed(rest, depth, tilt)) for depth in DEPTHS[1:] for tilt in np.linspace(-0.2, 0.2, 9)]
    )
    motion = fit_motion_model(project(rest), images - project(rest))
    true = project(pressed(rest, 5.1, 0.13))
    found = generator(0, "gone").random(91) > 0.3
    by_modes = np.linalg.norm(motion.fill(true, found) - true, axis=1)[~found].max()
    smooth = np.linalg.norm(MotionModel(project(rest)).fill(true, found) - true, axis=1)[~found].max()
    assert by_modes < 0.1
    assert by_modes < smooth


def test_the_estimate_does_not_look_at_what_is_not_found():
    rest = project(markers(37))
    seen, found = rest + 2.0, np.arange(37) % 5 > 0
    seen[~found] = np.nan
    np.testing.assert_allclose(MotionModel(rest).fill(seen, found), rest + 2.0, atol=1e-4)


def test_a_jump_and_an_image_without_dots_are_flagged():
    pixels = project(markers(91))
    tracker = Tracker(MotionModel(pixels))
    assert not tracker.step(pixels).jumped
    assert tracker.step(np.empty((0, 2))).jumped
    assert not tracker.step(pixels).jumped
    assert tracker.step(pixels + np.array([4.0, 0.0])).jumped


def test_after_a_sudden_release_every_marker_has_its_number_again():
    rest = project(markers(169))
    tracker = Tracker(MotionModel(rest))
    for depth in DEPTHS:
        tracker.step(project(pressed(markers(169), depth)))
    for _ in range(3):
        sighting = tracker.step(rest)
        assert sighting.blob.tolist() == list(range(169))


def test_nothing_to_follow_is_refused():
    with refused("tracker-no-marker"):
        Tracker(MotionModel(np.empty((0, 2))))


def test_images_become_tracks():
    dome = build_skin(DomeSpec())
    layout = place_markers(dome, MarkerSpec(count=37))
    mark = place_orientation_mark(dome, layout)
    truth, images = [], []
    for depth in DEPTHS:
        pixels = project(pressed(np.vstack([layout.positions, mark]), depth))
        truth.append(pixels[:-1])
        images.append(draw_dots(pixels, 7.0, 1.0, 120.0, (260, 346)).astype(np.uint8))
    detector = prepare_detector(images[0])
    naming = assign_markers(detector.find(images[0]).positions_px, build_pattern(layout.positions, project, mark))
    tracks = find_markers(images, detector, naming)
    assert len(tracks) == len(DEPTHS)
    assert tracks.found.all()
    assert not tracks.jumped.any()
    np.testing.assert_allclose(tracks.positions_px, truth, atol=0.05)


@pytest.mark.parametrize(("kept", "jumped"), [(10, False), (9, True)])
def test_half_of_the_markers_are_enough_to_go_on(kept: int, jumped: bool) -> None:
    grid = np.stack(np.meshgrid(np.arange(5.0), np.arange(4.0)), axis=-1).reshape(-1, 2) * 10.0 + 50.0
    tracker = Tracker(MotionModel(grid))
    seen = np.arange(20) % 2 == 0
    seen[np.flatnonzero(seen)[kept:]] = False
    for found, state in (tracker.follow(grid[seen], tracker.begin()), tracker.reassign(grid[seen], grid)):
        assert found.found.tolist() == seen.tolist()
        assert found.jumped == jumped
        assert found.positions_px == pytest.approx(grid, abs=1e-6)
        assert state.last_px == pytest.approx(grid, abs=1e-6)
    step = np.array([2.0, -1.0])
    moved = grid + step
    first, state = tracker.follow(moved, tracker.begin())
    assert not first.jumped
    second, _ = tracker.follow(moved + step, state)
    assert second.positions_px == pytest.approx(moved + step)
    nothing, same = tracker.follow(np.empty((0, 2)), state)
    assert nothing.jumped
    assert same is state
    assert nothing.positions_px.tolist() == state.last_px.tolist()
