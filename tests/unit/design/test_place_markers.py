from pathlib import Path

import numpy as np
import pytest

from errors import refused
from palpate.design import Dome, MarkerLayout, MarkerSpec, place_markers, ring_diameters
from palpate.design.rings import ring_count

DOME = Dome(20.0, 20.0, 2.0)


@pytest.mark.parametrize(
    ("count", "diameters"),
    [
        (7, (18,)),
        (37, (10, 20, 30)),
        (91, (6, 12, 18, 24, 30)),
        (169, (5, 10, 15, 20, 25, 30, 35)),
        (19, (17.5, 35.0)),
    ],
)
def test_rings_have_the_published_diameters(count: int, diameters: tuple[float, ...]) -> None:
    positions = place_markers(DOME, MarkerSpec(count=count)).positions
    assert len(positions) == count
    np.testing.assert_allclose(positions[0], [0, 0, 20], atol=1e-12)
    rho = np.hypot(positions[:, 0], positions[:, 1])
    expected = np.concatenate([[0.0], *(np.full(6 * k, d / 2) for k, d in enumerate(diameters, 1))])
    np.testing.assert_allclose(rho, expected, atol=1e-12)
    np.testing.assert_allclose(DOME.distance(positions), 0.0, atol=1e-12)


@pytest.mark.parametrize("count", [7, 37, 91, 169, 127])
def test_every_ring_starts_at_azimuth_zero_and_is_even(count: int) -> None:
    positions = place_markers(DOME, MarkerSpec(count=count)).positions
    start = 1
    for k in range(1, (ring_count(count) or 0) + 1):
        ring = positions[start : start + 6 * k]
        azimuth = np.mod(np.arctan2(ring[:, 1], ring[:, 0]) + 1e-9, 2 * np.pi)
        np.testing.assert_allclose(azimuth, 2 * np.pi * np.arange(6 * k) / (6 * k), atol=1e-8)
        start += 6 * k


def test_presets_scale_with_the_base() -> None:
    assert ring_diameters(37, base_radius=10.0) == (5.0, 10.0, 15.0)


def test_own_rings_give_the_count() -> None:
    spec = MarkerSpec(ring_diameters=(8.0, 25.0))
    assert spec.count == 19
    assert len(place_markers(DOME, spec)) == 19


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        ({"count": 100}, ("marker-count-not-rings", "91", "127")),
        ({"count": 0}, ("greater_than_equal", "1")),
        ({"count": 5000}, ("marker-count-not-rings", "1261")),
        ({"ring_diameters": (10.0, 5.0)}, ("rings-not-growing",)),
        ({"ring_diameters": (10.0, 15.0), "count": 37}, ("marker-count-differs", "19", "37")),
        ({"ring_diameters": (10.0,), "file": "dots.csv"}, ("layout-twice",)),
    ],
)
def test_bad_layouts_are_refused_with_the_numbers(bad: dict[str, object], says: tuple[str, ...]) -> None:
    with refused(*says):
        MarkerSpec(**bad)


def test_a_marker_outside_has_no_height() -> None:
    layout = place_markers(DOME, MarkerSpec(ring_diameters=(10.0, 41.0)))
    assert layout.on_dome.sum() == 7
    assert np.isnan(layout.positions[~layout.on_dome, 2]).all()


def write(folder: Path, text: str) -> MarkerSpec:
    path = folder / "dots.csv"
    path.write_text(text)
    return MarkerSpec(file=path)


def test_a_free_layout_is_carried_to_the_surface(tmp_path: Path) -> None:
    layout = place_markers(DOME, write(tmp_path, "y_mm, x_mm\n4,3\n\n0,-12\n"))
    np.testing.assert_allclose(layout.positions, [[3, 4, np.sqrt(375)], [-12, 0, 16]], atol=1e-12)


def test_a_free_layout_may_give_heights(tmp_path: Path) -> None:
    layout = place_markers(DOME, write(tmp_path, "x_mm,y_mm,z_mm\n12,0,16\n"))
    np.testing.assert_allclose(layout.positions, [[12, 0, 16]])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", ("table-empty",)),
        ("x,y\n1,2\n", ("columns-wrong", "x_mm,y_mm")),
        ("x_mm,y_mm\n", ("table-empty",)),
        ("x_mm,y_mm\n1,2\n3,four\n", ("row-not-numbers", "dots.csv:3", "four")),
        ("x_mm,y_mm\n1,2,3\n", ("header-length-wrong", "2", "3")),
        ("x_mm,y_mm\n1,nan\n", ("row-not-numbers", "2")),
        ("x_mm,y_mm,z_mm\n12,0,15\n", ("point-off-surface",)),
        ("x_mm,y_mm,z_mm\n12,0,-16\n", ("point-below-base",)),
    ],
)
def test_a_bad_layout_file_is_an_error_with_its_place(tmp_path: Path, text: str, says: tuple[str, ...]) -> None:
    with refused(*says):
        place_markers(DOME, write(tmp_path, text))


def test_a_missing_or_binary_layout_file_is_an_error(tmp_path: Path) -> None:
    with refused("file-unreadable", "none.csv"):
        place_markers(DOME, MarkerSpec(file=tmp_path / "none.csv"))
    (tmp_path / "dots.csv").write_bytes(bytes(range(128, 256)))
    with refused("table-no-numbers", "dots.csv"):
        place_markers(DOME, MarkerSpec(file=tmp_path / "dots.csv"))


def test_count_and_file_must_agree(tmp_path: Path) -> None:
    spec = write(tmp_path, "x_mm,y_mm\n1,2\n")
    with refused("marker-count-differs", "1", "7"):
        place_markers(DOME, MarkerSpec(file=spec.file, count=7))


def test_the_closest_pair_is_that_of_all_distances() -> None:
    positions = np.random.default_rng(0).normal(0, 9, (60, 3))
    positions[7, 2] = np.nan  # not on the dome
    first, second, distance = MarkerLayout(positions, 0.6).closest_pair()
    every = np.linalg.norm(positions[:, None] - positions, axis=-1) + np.diag(np.full(60, np.inf))
    assert distance == pytest.approx(np.nanmin(every))
    assert every[first, second] == pytest.approx(distance)


def test_two_markers_in_one_place_are_a_pair() -> None:
    first, second, distance = MarkerLayout(np.array([[0.0, 0, 9], [5, 0, 9], [5, 0, 9]]), 0.6).closest_pair()
    assert (sorted((first, second)), distance) == ([1, 2], 0.0)
