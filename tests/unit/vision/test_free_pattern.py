"""A layout without rings among blobs: found under turns, shears and losses, and doubted with its reason."""

import numpy as np
import pytest

from palpate.vision.fit_free_pattern import fit_free_pattern
from palpate.vision.pattern import MarkerPattern, PatternFit, build_pattern

RNG = np.random.default_rng(17)
PLACES = np.array([p for p in RNG.uniform(-9, 9, (400, 2)) if np.hypot(*p) < 9.0])


def scattered(count: int = 20, apart: float = 2.6) -> np.ndarray:
    """Places at least so far apart, in a disc."""
    chosen: list[np.ndarray] = []
    for place in PLACES:
        if len(chosen) < count and all(np.hypot(*(place - other)) > apart for other in chosen):
            chosen.append(place)
    return np.column_stack([chosen, 20.0 - 0.01 * np.square(chosen).sum(axis=1)])


LAYOUT = scattered()


def project(points: np.ndarray) -> np.ndarray:
    return 8.0 * points[..., :2] + [170.0, 130.0]


def pattern(mark: np.ndarray | None = None) -> MarkerPattern:
    return build_pattern(LAYOUT, project, mark)


def shown(turn_deg: float = 0.0, mirror: bool = False, bend: float = 0.0) -> np.ndarray:
    flat = (project(LAYOUT) - [170.0, 130.0]) * [1, -1 if mirror else 1]
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    flat = flat @ np.array([[1.1 * c, s], [-s, 0.95 * c]])
    return flat + bend * np.column_stack([flat[:, 0] ** 2, flat[:, 0] * flat[:, 1]]) / 72.0 + [160.0, 120.0]


def fit(blobs: np.ndarray, of: MarkerPattern | None = None) -> PatternFit:
    found = fit_free_pattern(blobs, of or pattern())
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("turn_deg", "mirror", "bend"), [(0.0, False, 0.0), (100.0, False, 0.05), (-40.0, True, 0.04)]
)
def test_every_marker_finds_its_blob_through_turn_mirror_and_bend(turn_deg: float, mirror: bool, bend: float) -> None:
    order = np.random.default_rng(1).permutation(len(LAYOUT))
    found = fit(shown(turn_deg, mirror, bend)[order])
    assert found.blob.tolist() == np.argsort(order).tolist()
    assert (found.mirrored, found.doubt, found.count) == (mirror, "", len(LAYOUT))
    assert found.residual_px < 0.6
    assert found.places_px == pytest.approx(shown(turn_deg, mirror, bend), abs=2.0)


def test_missing_markers_are_expected_where_they_would_be() -> None:
    gone = np.arange(len(LAYOUT)) % 6 == 0
    found = fit(shown()[~gone])
    assert (found.blob[gone] == -1).all()
    assert (found.blob[~gone] >= 0).all()
    assert found.places_px == pytest.approx(shown(), abs=0.8)


def test_the_mark_is_expected_beside_its_markers_with_its_deviation() -> None:
    mark = np.array([1.0, 10.5, 18.0])
    found = fit(shown(25.0), pattern(mark))
    assert found.marks_px is not None
    assert found.mark_axes_px is not None
    flat = project(mark) - [170.0, 130.0]
    c, s = np.cos(np.radians(25.0)), np.sin(np.radians(25.0))
    assert found.marks_px[0] == pytest.approx(
        flat @ np.array([[1.1 * c, s], [-s, 0.95 * c]]) + [160.0, 120.0], abs=0.5
    )
    assert found.mark_axes_px[0] == pytest.approx(0.2 * np.eye(2)), "no less than a fifth of a pixel"
    shaken = fit(shown(25.0) + np.random.default_rng(2).normal(0, 0.3, (len(LAYOUT), 2)), pattern(mark))
    assert shaken.mark_axes_px is not None
    assert 0.3 < shaken.mark_axes_px[0, 0, 0] <= 0.05 * pattern(mark).spacing_px + 1e-9
    assert shaken.mark_axes_px[0, 0, 1] == 0.0


@pytest.mark.parametrize(("strange", "doubted"), [(5, False), (6, True)])
def test_many_other_blobs_between_the_markers_raise_doubt_and_far_ones_do_not(strange: int, doubted: bool) -> None:
    """Five and three hundredths of 20: five are allowed."""
    dots = shown()
    rng, others = np.random.default_rng(6), []
    while len(others) < strange:
        place = dots.mean(axis=0) + rng.uniform(-45, 45, 2)
        if np.linalg.norm(dots - place, axis=1).min() > 8.0:
            others.append(place)
    found = fit(np.vstack([dots, others]))
    assert found.count == len(LAYOUT)
    assert bool(found.doubt) == doubted
    assert (str(strange) in found.doubt) == doubted
    away = dots.mean(axis=0) + 200.0 * np.column_stack([np.cos(np.arange(9.0)), np.sin(np.arange(9.0))])
    assert fit(np.vstack([dots, away])).doubt == ""


def test_strewn_blobs_and_rough_ones_are_doubted_and_too_few_have_no_fit() -> None:
    strewn = np.random.default_rng(7).uniform(90, 230, (20, 2))
    assert fit(strewn).doubt
    assert fit_free_pattern(shown()[:2], pattern()) is None
    assert fit_free_pattern(np.tile(shown()[:1], (5, 1)), pattern()) is None
