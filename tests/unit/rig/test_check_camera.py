"""A camera with one fault is named by it, and a good one has no finding: drawn discs with analytic edges."""

import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.special import ndtr

from errors import refused
from palpate.camera import Source, open_source
from palpate.cli import check_sensor, main
from palpate.core import PalpateError
from palpate.rig import CameraCheckSpec, check_camera, find_automatic_controls

SHAPE, REST, RADIUS, SPACING = (126, 150), 10, 3.2, 15.0
Image = np.ndarray[Any, Any]
DATA = Path(__file__).parents[3] / "examples" / "data"


def hexagon(rings: int = 3) -> Image:
    cells = [(a, b) for a in range(-rings, rings + 1) for b in range(-rings, rings + 1) if abs(a + b) <= rings]
    return np.array([[a + b / 2, b * np.sqrt(3) / 2] for a, b in cells]) * SPACING


def draw(
    number: int,
    *,
    shift: Any = (0.0, 0.0),
    zoom: float = 1.0,
    edge: float = 0.8,
    light: float = 1.0,
    level: float = 180.0,
    contrast: float = 0.6,
    noise: float = 1.5,
    shade: float = 0.1,
    motion: float = 0.0,
    red: float | None = None,
) -> Image:
    """One image of discs, with edges of a normal distribution; a motion is the mean of shifted images."""
    rng = np.random.default_rng(number)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    cover, steps = np.zeros(SHAPE), motion * np.linspace(-0.4, 0.4, 5 if motion else 1)
    for place in np.array(SHAPE)[::-1] / 2.0 + zoom * hexagon() + np.asarray(shift):
        for step in steps:
            distance = np.hypot(x - place[0] - step * 0.8, y - place[1] - step * 0.6)
            cover += ndtr((RADIUS - distance) / edge) / len(steps)
    image = level * light * (1.0 - shade * x / SHAPE[1]) * (1.0 - contrast * cover)
    if red is not None:
        image = image[..., None] * [0.8, 0.9, 0.85 * red]
    return np.clip(np.rint(image + rng.normal(0, noise, image.shape)), 0, 255).astype(np.uint8)


def series(change: Callable[[float], dict[str, Any]] = lambda part: {}) -> list[Image]:
    """Images at rest whose properties depend on their part (0 to 1) of the series."""
    return [draw(number, **change(number / (REST - 1))) for number in range(REST)]


def shaking(part: float) -> dict[str, Any]:
    return {"shift": np.random.default_rng(round(part * 1000)).normal(0, 0.4, 2)}


def found(rest: list[Image], press: list[Image] | tuple[()] = (), times: Any = ()) -> list[str]:
    return [one.code for one in check_camera(rest, press, times).findings]


FAULTS: dict[str, Callable[[float], dict[str, Any]]] = {
    "blank": lambda part: {"level": 12.0, "contrast": 0.0},
    "saturated": lambda part: {"level": 265.0},
    "dark": lambda part: {"level": 45.0},
    "at-border": lambda part: {"shift": (28.5, 0.0)},
    "contrast": lambda part: {"contrast": 0.14, "noise": 1.0},
    "evenness": lambda part: {"shade": 0.97},
    "focus": lambda part: {"edge": 0.75 * RADIUS},
    "noise": lambda part: {"noise": 14.0},
    "motion-blur": lambda part: {"motion": 4.0},
    "vibration": shaking,
    "drift": lambda part: {"shift": (0.4 * part, 0.3 * part)},
    "magnification": lambda part: {"zoom": 1.0 + 0.01 * part},
    "sharpness": lambda part: {"edge": 0.8 + 0.5 * part},
    "brightness": lambda part: {"light": 1.0 - 0.1 * part},
    "white-balance": lambda part: {"red": 1.0 - 0.1 * part},
}


@pytest.mark.parametrize("kind", FAULTS)
def test_a_fault_is_the_only_finding(kind: str) -> None:
    assert found(series(FAULTS[kind])) == [kind]


@pytest.mark.parametrize(
    "change", [lambda part: {}, lambda part: {"red": 1.0}, lambda part: {"contrast": -0.6, "level": 120.0}]
)
def test_a_good_camera_has_no_finding(change: Callable[[float], dict[str, Any]]) -> None:
    """Grey and colour images, dark and bright markers, with a press that lights some markers and moves them."""
    press = [draw(number + REST, **{**change(1.0), "zoom": 1.0 + 0.01 * number}) for number in range(5)]
    for number, image in enumerate(press):
        image[:50] = (image[:50] * (1.0 - 0.03 * number)).astype(np.uint8)
    assert found(series(change), press, np.arange(REST) / 30.0) == []


def test_automatic_exposure_changes_all_markers_of_a_press() -> None:
    press = [draw(number + REST, light=1.0 - 0.03 * number, zoom=1.0 + 0.01 * number) for number in range(6)]
    assert found(series(), press) == ["auto-exposure"]


def test_a_frozen_camera_repeats_its_image() -> None:
    image = draw(0)
    assert found([image] * REST) == ["frozen"]


def test_time_stamps_show_missing_and_irregular_images() -> None:
    rest, even = series(), np.arange(REST + 3) / 30.0
    assert found(rest, (), even[:REST]) == []
    assert found(rest, (), np.delete(even, [4, 9, 10])) == ["dropped"]
    assert found(rest, (), np.cumsum(np.random.default_rng(0).gamma(3.0, 1.0, REST)) / 30.0) == ["irregular"]


def test_motion_blur_is_measured_in_pixels() -> None:
    for length in (2.0, 4.0):
        check = check_camera([draw(number, motion=length) for number in range(4)])
        value = next(one.value for one in check.figures if one.code == "motion-blur")
        assert value == pytest.approx(length, rel=0.25)


def test_noise_is_that_of_centres_between_images() -> None:
    """The spread of centres is that of the Cramér-Rao bound, 2 (noise / contrast) √(s / (√π d)), and 30 % more."""
    check = check_camera([draw(number, noise=6.0, shade=0.0) for number in range(20)])
    value = next(one.value for one in check.figures if one.code == "noise")
    bound = 2.0 * 6.0 / (0.6 * 180.0) * np.sqrt(0.8 / (np.sqrt(np.pi) * 2.0 * RADIUS))
    assert bound * 0.9 < value < bound * 1.3


def test_limits_are_settings() -> None:
    rest = series(FAULTS["dark"])
    assert check_camera(rest, spec=CameraCheckSpec(dark=0.1)).as_dict()["passed"]


def test_unreadable_images_are_counted_and_no_image_is_refused() -> None:
    error = PalpateError("The file is damaged.", "Record it again.", code="image-unreadable")
    assert found([*series(), error]) == ["unreadable"]
    covered, larger = draw(9, level=12.0, contrast=0.0), np.pad(draw(9), 8)
    assert found([*series(), covered, larger]) == ["unreadable"]
    with refused("rest-image-missing"):
        check_camera([error])


def test_the_command_writes_a_report_and_answers_with_its_exit_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for number, image in enumerate(series(FAULTS["focus"])):
        cv2.imwrite(str(tmp_path / f"{number:02d}.png"), image)
    words = ["sensor", "check", str(tmp_path), "--json", "--out", str(tmp_path / "report")]
    with pytest.raises(SystemExit) as ended:
        main(words)
    shown = json.loads(capsys.readouterr().out)
    assert ended.value.code == 1
    assert (shown["passed"], shown["findings"], shown["rest_images"]) == (False, ["focus"], REST)
    assert sorted(path.name for path in (tmp_path / "report").iterdir()) == ["check.json", "check.md", "images.png"]
    with pytest.raises(SystemExit) as ended:
        main([*words[:-2], "--focus", "1"])
    assert ended.value.code == 0
    assert json.loads(capsys.readouterr().out)["passed"]


class LiveCamera(Source):
    """A camera that buffers five blank images and takes one every 20 ms; the later images show a press."""

    live = True
    name = "a camera"

    def images(self) -> Iterator[Image]:
        for number in range(200):
            time.sleep(0.02)
            yield np.zeros(SHAPE, np.uint8) if number < 5 else draw(number, zoom=1.0 if number < 15 else 1.02)


def test_a_live_camera_is_read_at_once_and_its_buffered_images_are_left_out(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(check_sensor, "open_source", lambda text: LiveCamera())
    words = ["sensor", "check", "7", "--press", "7", "--rest-images", "10", "--press-images", "4", "--json"]
    with pytest.raises(SystemExit) as ended:
        main([*words, "--irregular", "1", "--dropped", "1"])
    shown = json.loads(capsys.readouterr().out)
    assert (ended.value.code, shown["rest_images"], shown["press_images"]) == (0, 10, 4)
    assert {"dropped", "irregular"} <= {one["code"] for one in shown["figures"]}
    with pytest.raises(SystemExit):
        main([*words[:3], "--rest-images", "4", "--interval", "0.1", "--json"])
    shown = json.loads(capsys.readouterr().out)
    assert shown["rest_images"] == 4
    assert not {"dropped", "irregular"} & {one["code"] for one in shown["figures"]}


def test_a_recording_has_images_at_rest_and_of_presses(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["sensor", "check", str(DATA / "recording" / "poses.csv"), "--press-images", "5", "--json"])
    shown = json.loads(capsys.readouterr().out)
    assert (ended.value.code, shown["rest_images"], shown["press_images"]) == (0, 3, 5)


def test_a_camera_is_named_by_its_number_or_its_device() -> None:
    for text in ("99", "/dev/video99"):
        with refused("source-not-opened", "camera 99"):
            open_source(text)


LISTED = """
User Controls

                     brightness 0x00980900 (int)    : min=-64 max=64 step=1 default=0 value=0
        white_balance_automatic 0x0098090c (bool)   : default=1 value=1
      white_balance_temperature 0x0098091a (int)    : min=2800 max=6500 step=1 default=4600 value=4600 flags=inactive

Camera Controls

                  auto_exposure 0x009a0901 (menu)   : min=0 max=3 default=3 value=3 (Aperture Priority Mode)
     exposure_dynamic_framerate 0x009a0903 (bool)   : default=0 value=0
"""


@pytest.mark.skipif(sys.platform == "win32", reason="the program is a script")
def test_automatic_controls_are_listed_with_the_command_that_fixes_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The program v4l2-ctl is replaced by one that prints a list in its format; no camera is attached here."""
    program = tmp_path / "v4l2-ctl"
    program.write_text(f"#!/bin/sh\n[ \"$2\" = /dev/video3 ] && cat <<'END'\n{LISTED}END\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")

    class Attached(type(open_source(str(DATA / "board")))):  # type: ignore[misc]
        device = "/dev/video3"

    figures = find_automatic_controls(Attached(str(DATA / "board")))
    assert {one.code: one.passed for one in figures} == {
        "auto_exposure": False,
        "exposure_dynamic_framerate": True,
        "white_balance_automatic": False,
    }
    assert "`v4l2-ctl -d /dev/video3 -c auto_exposure=1`" in figures[0].sentence
    assert find_automatic_controls(open_source(str(DATA / "board"))) == []


def test_images_of_another_shape_or_too_small_are_unreadable() -> None:
    good = series()
    other = [np.dstack([good[0]] * 3), good[0][:3, :3], good[0][:, :-20]]
    checked = check_camera([*good, *other], [good[0][:3]])
    assert [(one.code, one.value) for one in checked.findings] == [("unreadable", 4.0)]


def test_black_images_at_the_start_do_not_hide_the_markers() -> None:
    good = series()
    checked = check_camera([np.zeros_like(good[0])] * 3 + good)
    assert {one.code: one.value for one in checked.figures}["markers"] == len(hexagon())


def test_a_red_light_is_not_dark_and_a_caused_figure_is_named() -> None:
    red = [np.dstack([image // 20, image // 20, image]) for image in series()]
    assert "dark" not in found(red)
    checked = check_camera(series(lambda part: {"level": 30.0}))
    assert "dark" in [one.code for one in checked.findings]
    assert set(checked.caused).isdisjoint(one.code for one in checked.figures)
