"""What the browser asks for, and what it gets when that cannot be."""

import csv
import io
import json

import numpy as np
import pytest

from view_message import read_message

pytest.importorskip("fastapi", reason="the extra web is not there: pip install -e '.[web]'")

from fastapi import FastAPI
from made_up_presses import write_results
from starlette.testclient import TestClient

from palpate.viewer.design_cache import DesignCache
from palpate.viewer.library import DesignLibrary
from palpate.viewer.results import read_results
from palpate.viewer.routes import answer_errors, make_routes


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    app = FastAPI()
    answer_errors(app)
    folder = write_results(tmp_path_factory.mktemp("results"))
    app.include_router(make_routes(DesignCache({"": DesignLibrary(read_results(folder))})))
    return TestClient(app)


def test_shell_motion_and_markers_are_served(browser):
    _, shell = read_message(browser.get("/data/shell/1").content)
    meta, motion = read_message(browser.get("/data/motion/1?tilt=2&field=stress").content)
    _, markers = read_message(browser.get("/data/markers/1?tilt=2&azimuth=45").content)
    assert motion["displacement"].shape[1:] == shell["rest"].shape
    assert markers["positions"].shape == (len(meta["depths_mm"]), 19, 3)


@pytest.mark.parametrize(
    "path",
    [
        "/data/shell/99",
        "/data/shell/2",
        "/data/shell/-1",
        "/data/shell/1e3",
        "/data/shell/%2e%2e%2f%2e%2e%2fetc%2fpasswd",
        "/data/shell/made-7",
        "/data/motion/0?tilt=90",
        "/data/motion/0?tilt=nan",
        "/data/motion/0?tilt=inf",
        "/data/motion/0?tilt=x",
        "/data/markers/0?azimuth=nan",
        "/data/dome.glb?name=0&depth=99",
        "/data/dome.glb?name=0&depth=nan",
        "/data/grid.csv?where=import%20os",
    ],
)
def test_what_cannot_be_is_reported_and_not_a_fault(browser, path):
    assert browser.get(path).status_code in (404, 422)
    assert browser.get("/data/shell/0").status_code == 200


def test_markers_as_a_table_begin_at_rest(browser):
    rows = list(csv.DictReader(io.StringIO(browser.get("/data/markers.csv?name=0&tilt=3&azimuth=90").text)))
    assert len(rows) == 6 * 7
    assert (rows[0]["depth_mm"], rows[0]["z_mm"]) == ("0", "20.00000")
    assert float(rows[-1]["ry_deg"]) == pytest.approx(3)


def test_designs_that_are_kept_are_a_table(browser):
    rows = list(csv.DictReader(io.StringIO(browser.get("/data/grid.csv?where=markers >= 19").text)))
    assert [row["markers"] for row in rows] == ["19", "37"]


def test_designs_of_a_folder_of_results_have_the_name_of_their_study(tmp_path):
    app, shelf = FastAPI(), DesignCache({"my study #1": DesignLibrary(read_results(write_results(tmp_path)))})
    answer_errors(app)
    app.include_router(make_routes(shelf))
    browser = TestClient(app)
    assert browser.get("/data/shell/my%20study%20%231%2F1").status_code == 200
    assert browser.get("/data/markers.csv", params={"name": "my study #1/1"}).status_code == 200
    rows = browser.get("/data/grid.csv", params={"result": "my study #1"}).text.splitlines()
    assert len(rows) == 1 + 3
    for path in ("/data/shell/1", "/data/shell/my%20study/1", "/data/grid.csv", "/data/learnt/errors.png?result=x"):
        assert browser.get(path).status_code == 422


def test_the_model_is_a_whole_gltf_file(browser):
    data = browser.get("/data/dome.glb?name=0&depth=3&tilt=2&azimuth=10").content
    assert data[:4] == b"glTF"
    assert int.from_bytes(data[8:12], "little") == len(data)
    size = int.from_bytes(data[12:16], "little")
    head = json.loads(data[20 : 20 + size])
    assert [mesh["name"] for mesh in head["meshes"]] == ["dome", "markers", "wall"]
    body = data[28 + size :]
    for accessor in head["accessors"]:
        view = head["bufferViews"][accessor["bufferView"]]
        width = {"VEC3": 12, "VEC4": 16, "SCALAR": 4}[accessor["type"]]
        assert view["byteLength"] == width * accessor["count"]
        assert view["byteOffset"] + view["byteLength"] <= len(body)
    top = head["accessors"][0]["max"][1]
    assert top == pytest.approx(0.022 - 0.003, abs=2e-3)  # m, after 3 mm
    indices = head["accessors"][2]
    view = head["bufferViews"][indices["bufferView"]]
    triangles = np.frombuffer(body, "<u4", indices["count"], view["byteOffset"])
    assert triangles.max() == head["accessors"][0]["count"] - 1
