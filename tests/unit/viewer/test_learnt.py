"""The viewer on a sensor that was learnt from a recording: its report, its pictures, its readings."""

import json
from pathlib import Path

import numpy as np
import pytest

from errors import refused

pytest.importorskip("nicegui")

from fastapi.testclient import TestClient

from palpate.camera import open_source
from palpate.viewer.live import open_recorded_live
from palpate.viewer.live_page import list_figures
from palpate.viewer.pages import build_app
from palpate.viewer.trained import error_columns, error_rows, is_trained_sensor, read_trained_sensor
from presses import copy_learnt_sensor


@pytest.fixture(scope="module")
def learnt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of palpate recording train, with the recording below it."""
    return copy_learnt_sensor(tmp_path_factory.mktemp("learnt"))


def test_the_table_has_every_estimator_and_the_kept_one_first(learnt):
    assert is_trained_sensor(learnt)
    found = read_trained_sensor(learnt)
    rows, report = error_rows(found), json.loads((learnt / "report.json").read_text())
    assert rows[0][0] == report["best"]
    assert {row[0] for row in rows} == {one["name"] for one in report["estimators"]}
    assert all(len(row) == len(error_columns(found)) == 2 + 2 * 3 for row in rows)
    assert float(rows[0][2]) == pytest.approx(
        next(one for one in report["estimators"] if one["name"] == report["best"])["errors"]["rx"]["rmse"], rel=5e-3
    )


def test_images_are_read_from_the_first_on_and_dots_drawn_where_they_are(learnt):
    found = read_trained_sensor(learnt)
    live = open_recorded_live(found.model, open_source(str(learnt / "recording" / "images")))
    steps = [live.step() for _ in range(5)]
    live.close()
    assert live.size_px == (420, 420)
    assert [step.reading.image for step in steps] == [1, 2, 3, 4, 5]
    for step in steps:
        assert step.positions_px.shape == live.rest_px.shape
        assert step.found.sum() == step.reading.found > 50
        bright = step.image[tuple(step.positions_px[step.found].round().astype(int).T[::-1])]
        assert np.mean(bright > 128) > 0.95
    moved = np.linalg.norm(steps[0].positions_px - live.rest_px, axis=1)
    assert np.median(moved) > 3.0
    assert [row[0] for row in list_figures(steps[0].reading, None)] == ["rx", "ry", "depth", "tilt"]
    truth = [row[4] for row in list_figures(steps[0].reading, (1.0, 2.0, 3.0))][:3]
    assert [text.split("0")[-1].strip() for text in truth] == ["°", "°", "mm"]


def test_an_image_of_another_size_is_refused(learnt, tmp_path):
    cv2 = pytest.importorskip("cv2")
    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((100, 90), np.uint8))
    with refused("image-size-changed", "90", "100"):
        open_recorded_live(read_trained_sensor(learnt).model, open_source(str(tmp_path)))


def test_pages_and_pictures_are_served_and_no_other_file(learnt):
    client = TestClient(build_app(learnt))
    assert client.get("/").status_code == 200
    picture = client.get("/data/learnt/errors.png")
    assert picture.content == (learnt / "errors.png").read_bytes()
    for name in ("model.h5", "..%2Fmodel.h5", "report.json"):
        assert client.get(f"/data/learnt/{name}").status_code in (404, 422)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "file-unreadable"),
        ("[]", "report-unreadable"),
        ("{}", "report-unreadable"),
        ('{"estimators": 3}', "report-unreadable"),
    ],
)
def test_a_damaged_report_is_named(learnt, tmp_path, text, code):
    (tmp_path / "model.h5").write_bytes((learnt / "model.h5").read_bytes())
    (tmp_path / "report.json").write_text(text)
    with refused(code, "report.json"):
        read_trained_sensor(tmp_path)
