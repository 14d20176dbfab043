"""Readings for other programs: by HTTP, websocket and in C++; slow clients, a camera unplugged, wrong tokens."""

import asyncio
import json
import shutil
import subprocess
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from errors import refused

pytest.importorskip("starlette", reason="the extra web is not there: pip install -e '.[web]'")

import cv2
import uvicorn
from starlette.testclient import TestClient

from palpate.calibration import Deviation
from palpate.camera import RenderSpec, Source
from palpate.core import PalpateError
from palpate.design import Design, build_skin, place_markers
from palpate.learn import open_predictor
from palpate.sensor import Broadcast, Sensor, Unit, open_sensor
from palpate.simulation import SimulatedUnit
from palpate.viewer import Feed, ServeSpec, build_readings_app, follow_readings
from palpate.viewer.guard import Guard
from palpate.viewer.serve_readings import SCHEMA_VERSION
from palpate.viewer.server import bind_server, page_url
from small_chain import DOME, MARKERS, write_small_model

TOKEN = "0123456789abcdef"
CPP = Path(__file__).parents[3] / "examples" / "cpp"
IMAGES = 12


def rest_image() -> np.ndarray:
    skin = build_skin(DOME)
    scene = SimulatedUnit(Design.of_skin(skin, place_markers(skin, MARKERS)), Deviation(), RenderSpec(noise=2.0))
    return scene.render_rest()


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return open_predictor(write_small_model(tmp_path_factory.mktemp("model") / "model.onnx"))


@pytest.fixture
def sensor(model: Any) -> Sensor:
    skin = build_skin(DOME)
    return open_sensor([rest_image()], Unit(Design.of_skin(skin, place_markers(skin, MARKERS))), model)


class Unplugged(Source):
    """A camera that gives a dozen images, then nothing any more; opened again, it gives a dozen again."""

    opened = 0

    def __init__(self) -> None:
        type(self).opened += 1
        self._image = rest_image()

    @property
    def name(self) -> str:
        return "a camera that is unplugged"

    def images(self) -> Iterator[Any]:
        if type(self).opened == 2:
            raise PalpateError("The camera cannot be opened.", "Plug it in.", code="source-not-opened")
        for _ in range(IMAGES):
            time.sleep(0.01)
            yield self._image
        yield PalpateError("The camera gives nothing any more.", "Plug it in.", code="camera-gone")


@pytest.fixture
def served(sensor: Sensor) -> Iterator[str]:
    Unplugged.opened = 0
    door, listener = bind_server(ServeSpec(port=0, token=TOKEN))
    app = Guard(build_readings_app(sensor, Feed(Unplugged, retry_s=0.3)), door)
    server = uvicorn.Server(uvicorn.Config(app, log_level="warning", lifespan="on", timeout_graceful_shutdown=1))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    yield page_url(door, "reading")
    server.should_exit = True
    thread.join(10)
    listener.close()


def test_a_camera_that_is_unplugged_is_said_once_and_comes_back(served: str) -> None:
    rows = []
    for row in follow_readings(served):
        rows.append(row)
        cameras = [each["camera"] for each in rows]
        if (
            "gone" in cameras and cameras[-3:] == ["there"] * 3
        ):  # a client that is late misses images of the first dozen
            break
    assert cameras.count("gone") == 1, "two tries failed, and it is said once"
    numbers = [row["image"] for row in rows]
    assert numbers == list(range(numbers[0], numbers[0] + len(rows))), "none is lost"
    assert all(row["lost"] == 0 for row in rows)
    bad = [row for row in rows if row["reason"]]
    assert bad[0]["reason"] == "The camera gives nothing any more."
    assert bad[0]["rx_deg"] is None
    assert rows[-1]["depth_mm"] is not None


def test_a_slow_client_loses_the_oldest_and_hears_how_many() -> None:
    async def play() -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
        hub = Broadcast(most=5)
        with hub.listen() as quick, hub.listen() as slow:
            seen = []
            for number in range(20):
                hub.publish({"image": number})
                seen.append(await quick.take())
            late = [await slow.take() for _ in range(5)]
            hub.publish({"image": 20})
            late.append(await slow.take())
        assert len(hub) == 0
        return seen, late

    with ThreadPoolExecutor(1) as own:  # browser tests before this one may leave a loop running in this thread
        seen, late = own.submit(asyncio.run, play()).result()
    assert [row["lost"] for row in seen] == [0] * 20
    assert [(row["image"], row["lost"]) for row in late] == [(15, 15), (16, 0), (17, 0), (18, 0), (19, 0), (20, 0)]


def test_a_client_sends_an_image_and_gets_its_reading(sensor: Sensor) -> None:
    with TestClient(build_readings_app(sensor, Feed())) as client:
        assert client.get("/reading").status_code == 204
        _, png = cv2.imencode(".png", rest_image())
        row = client.post("/image", content=png.tobytes()).json()
        assert (row["schema"], row["found"]) == (SCHEMA_VERSION, 37)
        assert row["touching"] is False
        time.sleep(0.1)
        assert client.get("/reading").json() == client.get("/").json() == row
        with client.websocket_connect("/readings") as socket:
            client.post("/image", content=png.tobytes())
            sent = json.loads(socket.receive_text())
            assert (sent["schema"], sent["image"]) == (SCHEMA_VERSION, row["image"] + 1)
        refused = client.post("/image", content=b"no image")
        assert refused.status_code == 400
        assert refused.json()["code"] == "image-format-unknown"


def test_without_the_token_nothing_is_told(served: str) -> None:
    with refused("server-silent"):
        next(follow_readings(served.replace(TOKEN, "f" * 16)))
    with refused("server-silent"):
        next(follow_readings("http://127.0.0.1:9/reading"))


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler is there: apt install g++")
def test_the_cpp_header_compiles_and_reads(served: str, tmp_path: Path) -> None:
    program = tmp_path / "print_reading"
    words = ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", str(CPP / "print_reading.cpp"), "-o", str(program)]
    subprocess.run(words, check=True)
    first = next(follow_readings(served))
    port = served.split(":")[2].split("/")[0]
    read = subprocess.run([program, "127.0.0.1", port, TOKEN], capture_output=True, text=True, check=True)
    assert len(read.stdout.split()) == 3
    assert "depth_mm" in first
    wrong = subprocess.run([program, "127.0.0.1", port, "f" * 16], capture_output=True, text=True, check=False)
    assert wrong.returncode == 3
    assert "401" in wrong.stderr
