import numpy as np
import pytest
from posed_dome import posed_dots, project

from errors import refused
from palpate.core import generator
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.vision import assign_markers, build_pattern


def layout(count, height=20.0):
    dome = build_skin(DomeSpec(height=height))
    markers = place_markers(dome, MarkerSpec(count=count))
    return markers.positions, place_orientation_mark(dome, markers)


def right(names, truth):
    return not np.any((truth >= 0) & (names != truth))


@pytest.mark.parametrize("count", [37, 91, 169])
@pytest.mark.parametrize("height", [10.0, 20.0, 30.0])
def test_markers_of_any_pose_are_named_rightly_by_the_mark(count, height):
    positions, mark = layout(count, height)
    pattern = build_pattern(positions, project, mark)
    rng = generator(7, "poses", count, height)
    resolved = 0
    for _ in range(4):
        dots, truth, mirror = posed_dots(np.vstack([positions, mark]), count, rng)
        naming = assign_markers(dots, pattern)
        assert any(right(each.blob, truth) for each in (naming, *naming.alternatives))
        if not naming.ambiguous:
            resolved += 1
            assert right(naming.blob, truth)
            assert naming.mirrored == mirror
            assert naming.mark >= 0
    assert resolved >= 2


@pytest.mark.parametrize("count", [37, 91])
def test_without_a_mark_every_naming_that_fits_is_reported(count):
    positions, _ = layout(count)
    pattern = build_pattern(positions, project)
    dots, truth, _ = posed_dots(positions, count, generator(1, "no mark", count))
    naming = assign_markers(dots, pattern)
    assert naming.ambiguous
    assert len(naming.alternatives) == 11
    assert sum(right(each.blob, truth) for each in (naming, *naming.alternatives)) == 1


def test_a_hidden_mark_leaves_the_naming_ambiguous():
    positions, mark = layout(37)
    dots, _, _ = posed_dots(positions, 37, generator(1, "hidden"), missing=0.0, false=0.0)
    naming = assign_markers(dots, build_pattern(positions, project, mark))
    assert naming.ambiguous
    assert naming.mark == -1
    assert naming.found.all()


def test_a_false_dot_about_where_another_turn_has_the_mark_is_not_the_mark():
    """With the mark hidden, a false dot misled before it had to lie as near as the map of the others knows."""
    positions, mark = layout(91)
    pattern = build_pattern(positions, project, mark)
    rng = generator(4, "false mark")
    for place in range(12):
        dots = project(positions) + rng.normal(0, 0.1, (91, 2))
        beside = pattern.marks_px[place] + 0.1 * pattern.spacing_px * np.array([np.cos(place), np.sin(place)])
        naming = assign_markers(np.vstack([dots, beside]), pattern)
        assert naming.ambiguous
        assert naming.mark == -1
    assert not assign_markers(np.vstack([dots, pattern.marks_px[3] + 0.1]), pattern).ambiguous


def test_a_mark_among_many_false_dots_is_not_believed():
    """What chance puts into one of twelve places does not tell a turn."""
    positions, mark = layout(37)
    pattern = build_pattern(positions, project, mark)
    rng = generator(5, "crowd")
    kept = rng.random(37) > 0.4
    dots = project(positions[kept]) + rng.normal(0, 0.8, (kept.sum(), 2))
    crowd = rng.uniform(0, 1, (140, 2)) * [346, 260]
    crowd = crowd[np.linalg.norm(crowd[:, None] - project(positions)[None], axis=-1).min(axis=1) > 12]
    crowd = crowd[np.linalg.norm(crowd[:, None] - pattern.marks_px[None], axis=-1).min(axis=1) > 6]
    naming = assign_markers(np.vstack([dots, crowd, project(mark)]), pattern)
    assert naming.ambiguous


@pytest.mark.slow
@pytest.mark.parametrize("count", [37, 91, 169])
def test_of_hundreds_of_random_poses_none_is_misnamed_without_a_word(count):
    """The issue's row: any rotation, 20 px, 5°, 10 % missing, 5 % false; heights in turn."""
    rng, wrong, ambiguous, lost, strayed = generator(11, "thousand", count), 0, 0, 0, 0
    patterns = []
    for height in (10.0, 20.0, 30.0):
        positions, mark = layout(count, height)
        patterns.append((np.vstack([positions, mark]), build_pattern(positions, project, mark)))
    for number in range(120):
        points, pattern = patterns[number % 3]
        dots, truth, mirror = posed_dots(points, count, rng)
        naming = assign_markers(dots, pattern)
        real = np.isin(np.arange(len(dots)), truth[truth >= 0])
        for each in (naming,) if not naming.ambiguous else (naming, *naming.alternatives):
            misnamed = (each.blob >= 0) & real[each.blob] & (each.blob != truth)
            if not misnamed.any():
                break
        wrong += bool(misnamed.any()) or (not naming.ambiguous and naming.mirrored != mirror)
        ambiguous += naming.ambiguous
        lost += int(((truth >= 0) & (each.blob < 0)).sum())
        strayed += int(((truth >= 0) & (each.blob >= 0) & (each.blob != truth)).sum())
    assert wrong == 0
    assert lost == 0
    assert strayed <= 2  # a false dot nearer to the marker's place than its own dot, both within 0.3 px
    assert ambiguous <= 19  # of which 12 or so have lost their mark


def test_in_the_nominal_pose_turn_and_positions_are_those_of_the_camera():
    positions, mark = layout(91)
    pattern = build_pattern(positions, project, mark)
    naming = assign_markers(np.vstack([project(positions), project(mark)]), pattern)
    assert not naming.ambiguous
    assert naming.blob.tolist() == list(range(91))
    assert naming.turn_deg == pytest.approx(0.0, abs=0.1)
    np.testing.assert_allclose(naming.positions_px, project(positions))


def test_a_missing_marker_is_expected_where_it_would_be():
    positions, mark = layout(91)
    seen = np.delete(np.arange(91), [0, 17, 80])
    dots = np.vstack([project(positions[seen]), project(mark)])
    naming = assign_markers(dots, build_pattern(positions, project, mark))
    assert np.flatnonzero(~naming.found).tolist() == [0, 17, 80]
    np.testing.assert_allclose(naming.positions_px, project(positions), atol=0.5)


def test_the_symmetries_of_rings_are_twelve_and_of_a_free_layout_one():
    positions, _ = layout(37)
    pattern = build_pattern(positions, project)
    assert len(pattern.symmetries) == 12
    assert pattern.mirrored.sum() == 6
    assert pattern.symmetries[0].tolist() == list(range(37))
    free = positions + generator(0, "free").uniform(-0.5, 0.5, positions.shape)
    assert len(build_pattern(free, project).symmetries) == 1


@pytest.mark.parametrize("mirror", [False, True])
def test_a_layout_without_symmetry_needs_no_mark(mirror):
    positions, _ = layout(37)
    free = positions.copy()
    free[1:, :2] += generator(0, "free").uniform(-0.9, 0.9, (36, 2))
    dots, truth, _ = posed_dots(free, 37, generator(3, "free pose"), mirror=mirror)
    naming = assign_markers(dots, build_pattern(free, project))
    assert not naming.ambiguous
    assert right(naming.blob, truth)
    assert naming.mirrored == mirror


@pytest.mark.parametrize("dots", [np.empty((0, 2)), np.array([[100.0, 100.0]] * 4), np.full((2, 2), 50.0)])
def test_too_few_dots_are_refused(dots):
    positions, mark = layout(37)
    with refused("markers-not-assigned", "37"):
        assign_markers(dots, build_pattern(positions, project, mark))


def test_another_design_is_refused():
    positions, mark = layout(169)
    other, _ = layout(37)
    with refused("assignment-doubtful", "169"):
        assign_markers(project(other), build_pattern(positions, project, mark))


@pytest.mark.parametrize("count", [37, 91, 169])
@pytest.mark.parametrize("height", [10.0, 20.0, 30.0])
def test_a_print_that_is_off_as_a_whole_keeps_its_mark(count, height):
    """The map of the dots is fitted far from the mark: 0.25 mm of the whole print may not hide it."""
    positions, mark = layout(count, height)
    dome = build_skin(DomeSpec(height=height))
    moved = np.vstack([positions, mark])[:, :2] + [0.2, 0.15]
    printed = dome.inner_point(np.hypot(*moved.T), np.arctan2(moved[:, 1], moved[:, 0]))
    naming = assign_markers(project(printed), build_pattern(positions, project, mark))
    assert not naming.ambiguous
    assert naming.blob.tolist() == list(range(count))
