"""The press command as other programs use it."""

import json
from pathlib import Path

import pytest
from command_line import finish

from errors import check_values


@pytest.fixture(scope="module")
def pressed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    points = tmp_path_factory.mktemp("points") / "points.csv"
    points.write_text("x_mm,y_mm,z_mm\n0,0,20\n12,0,16\n-12,0,16\n")
    words = "press --height 20 --thickness 2 --tilt 5 --depth 2.4 --cells 8 --json --points"
    done = finish([*words.split(), points])
    assert done.returncode == 0, done.stderr
    shown: dict[str, object] = json.loads(done.stdout)
    return shown


def test_the_layout_is_the_agreed_one(pressed: dict[str, object]) -> None:
    agreed = {"inputs", "ended", "cpu_s", "unknowns", "newton_iterations", "images"}
    assert set(pressed) == agreed | {"ended_depth_mm", "jump_depth_mm", "message"}
    images = pressed["images"]
    assert isinstance(images, list)
    assert [round(image["depth_mm"], 9) for image in images] == [0, 0.8, 1.6, 2.4]
    for image in images:
        assert set(image) == {
            "depth_mm",
            "force_n",
            "energy_mj",
            "contact_energy_mj",
            "hold_tension_mpa",
            "apex_gap_mm",
            "dissipation_mj",
            "work_mj",
            "branch",
            "peak_pressure_mpa",
            "peak_stress_mpa",
            "contact_area_mm2",
            "points_mm",
        }
        assert len(image["points_mm"]) == 3


def test_a_press_about_x_is_mirror_symmetric(pressed: dict[str, object]) -> None:
    images = pressed["images"]
    assert isinstance(images, list)
    _, right, left = images[-1]["points_mm"]
    assert right == pytest.approx([-left[0], left[1], left[2]], abs=1e-9)
    assert images[-1]["force_n"][0] == pytest.approx(0, abs=1e-9)
    assert images[-1]["force_n"][2] > 0.05


def test_without_points_none_are_followed() -> None:
    done = finish(["press", "--depth", "0.8", "--cells", "6", "--json"])
    assert "points_mm" not in json.loads(done.stdout)["images"][0]


def test_people_get_a_table(tmp_path: Path) -> None:
    done = finish(["press", "--depth", "0.8", "--cells", "6"])
    assert done.returncode == 0
    check_values(done.stdout, "0.80 mm")


@pytest.mark.slow
def test_the_first_press_after_an_installation_says_that_it_compiles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    words = ["press", "--depth", "0.1", "--step", "0.1", "--cells", "4", "--contact", "frictionless"]
    first, second = finish(words).stderr, finish(words).stderr
    assert len(first.splitlines()) == len(second.splitlines()) + 1
