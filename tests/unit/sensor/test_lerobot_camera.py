"""The camera of LeRobot: on LeRobot itself where it is installed, else on stand-ins of the classes that it needs."""

import dataclasses
import importlib
import sys
import threading
import time
from enum import StrEnum
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import palpate.camera
from errors import check_values
from palpate.calibration import Deviation
from palpate.camera import RenderSpec, Source
from palpate.core import PalpateError
from palpate.design import Design, build_skin, place_markers
from palpate.fea import WallSpec
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.simulation import SimulatedUnit
from palpate.surrogate import TWIN_DERIVATIVES, write_twin
from presses import build_twin, solve_press
from small_chain import DOME, MARKERS, MATERIAL

PLUGIN = Path(__file__).parents[3] / "plugins" / "lerobot_camera_palpate"


def stand_ins():
    """Modules of LeRobot that the plug-in imports: what its documentation says of them, and no more."""

    class ColorMode(StrEnum):
        RGB, BGR = "rgb", "bgr"

    @dataclasses.dataclass(kw_only=True)
    class CameraConfig:
        fps: int | None = None
        width: int | None = None
        height: int | None = None

        @classmethod
        def register_subclass(cls, name):
            return lambda kind: kind

    class Camera:
        def __init__(self, config):
            self.fps, self.width, self.height = config.fps, config.width, config.height

    class DeviceNotConnectedError(ConnectionError):
        pass

    class DeviceAlreadyConnectedError(ConnectionError):
        pass

    return {
        "lerobot": {},
        "lerobot.cameras": {},
        "lerobot.cameras.camera": {"Camera": Camera},
        "lerobot.cameras.configs": {"CameraConfig": CameraConfig, "ColorMode": ColorMode},
        "lerobot.utils": {},
        "lerobot.utils.errors": {
            "DeviceNotConnectedError": DeviceNotConnectedError,
            "DeviceAlreadyConnectedError": DeviceAlreadyConnectedError,
        },
    }


@pytest.fixture(scope="module")
def plugin():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PLUGIN))
        try:
            importlib.import_module("lerobot.cameras.camera")
        except ImportError:
            for name, content in stand_ins().items():
                module = ModuleType(name)
                module.__dict__.update(content)
                patch.setitem(sys.modules, name, module)
        yield importlib.import_module("lerobot_camera_palpate")


class Paced(Source):
    """Numbered images of 6 x 4 pixels, one whenever `go` is released; the third cannot be read, the fifth is last."""

    def __init__(self):
        self.go, self.closed = threading.Semaphore(0), False

    @property
    def name(self):
        return "paced"

    def images(self):
        for number in range(5):
            self.go.acquire()
            yield PalpateError("torn", "Again.", code="image-damaged") if number == 2 else coloured(number)

    def close(self):
        self.closed = True


def coloured(number):
    image = np.zeros((4, 6, 3), np.uint8)
    image[...] = [number, 0, 200]  # blue, green, red
    return image


@pytest.fixture
def paced(plugin, monkeypatch):
    source = Paced()
    monkeypatch.setattr(sys.modules["lerobot_camera_palpate.camera"], "open_source", lambda text: source)
    yield source
    for _ in range(9):
        source.go.release()


def opened(plugin, paced, **values):
    paced.go.release()
    camera = plugin.PalpateCamera(plugin.PalpateCameraConfig(source="any", **values))
    camera.connect()
    return camera


def test_images_come_in_the_order_of_colours_that_was_asked_for(plugin, paced):
    camera = opened(plugin, paced)
    assert (camera.width, camera.height) == (6, 4)
    assert camera.async_read()[0, 0].tolist() == [200, 0, 0]
    assert camera.reading is None
    camera.config = plugin.PalpateCameraConfig(source="any", color_mode="bgr")
    paced.go.release()
    assert camera.async_read(2000)[0, 0].tolist() == [1, 0, 200]
    paced.go.release()
    camera._going = False
    paced.go.release()
    camera.disconnect()
    assert paced.closed
    assert not camera.is_connected


def test_an_image_is_handed_out_once_and_the_latest_again_and_again(plugin, paced):
    camera = opened(plugin, paced)
    first = camera.async_read()
    with pytest.raises(TimeoutError) as late:
        camera.async_read(50)
    check_values(str(late.value), 50)
    assert camera.read_latest(10_000) is first
    time.sleep(0.05)
    with pytest.raises(TimeoutError):
        camera.read_latest(10)
    threading.Timer(0.1, paced.go.release).start()
    assert camera.read()[0, 0, 2] == 1


def test_what_cannot_be_read_and_the_end_are_said(plugin, paced):
    camera = opened(plugin, paced)
    camera.async_read()
    paced.go.release()
    camera.async_read(2000)
    paced.go.release()
    time.sleep(0.05)
    with pytest.raises(TimeoutError) as late:
        camera.async_read(50)
    check_values(str(late.value), "torn")
    for _ in range(3):
        paced.go.release()
    camera._thread.join(2)
    assert camera.async_read()[0, 0, 2] == 4, "the last image is still there"
    with pytest.raises(ConnectionError):
        camera.async_read()
    camera.disconnect()
    with pytest.raises(ConnectionError):
        camera.read()


def test_another_size_a_second_connect_and_a_source_that_is_not_there_are_refused(
    plugin, paced, monkeypatch, tmp_path
):
    camera = opened(plugin, paced)
    with pytest.raises(ConnectionError):
        camera.connect()
    other = Paced()
    for _ in range(3):
        other.go.release()
    monkeypatch.setattr(sys.modules["lerobot_camera_palpate.camera"], "open_source", lambda text: other)
    wide = plugin.PalpateCamera(plugin.PalpateCameraConfig(source="any", width=640, height=480))
    with pytest.raises(ConnectionError) as left:
        wide.connect()
    check_values(str(left.value), 6, 4, 640, 480)
    monkeypatch.setattr(sys.modules["lerobot_camera_palpate.camera"], "open_source", palpate.camera.open_source)
    gone = plugin.PalpateCamera(plugin.PalpateCameraConfig(source=str(tmp_path / "nowhere")))
    with pytest.raises(ConnectionError) as left:
        gone.connect()
    check_values(str(left.value), "nowhere")
    with pytest.raises(ValueError) as bad:  # noqa: PT011
        plugin.PalpateCameraConfig(warmup_s=0)
    check_values(str(bad.value), "warmup_s")


def test_with_a_twin_every_image_has_a_reading(plugin, tmp_path):
    import cv2

    skin = build_skin(DOME)
    walls = [WallSpec(tilt_deg=tilt, depth=4.0, depth_step=0.5) for tilt in (0.0, 3.0, 6.0, 9.0)]
    mesh, solver = mesh_skin(skin, MeshSpec(cells=6)), SolverSpec(derivatives=TWIN_DERIVATIVES, edge_share=1.0)
    presses = [solve_press(mesh, MATERIAL, wall, solver) for wall in walls]
    write_twin(tmp_path / "twin.h5", build_twin(presses))
    scene = SimulatedUnit(Design.of_skin(skin, place_markers(skin, MARKERS)), Deviation(), RenderSpec(noise=1.0))
    (tmp_path / "images").mkdir()
    for number, image in enumerate([scene.render_rest(), list(scene.render_press(presses[1]))[6]]):
        cv2.imwrite(str(tmp_path / "images" / f"{number}.png"), image)
    config = {"source": str(tmp_path / "images"), "twin": str(tmp_path / "twin.h5"), "markers": 37}
    camera = plugin.PalpateCamera(plugin.PalpateCameraConfig(**config))
    camera.connect()
    camera._thread.join(10)
    assert camera.async_read().shape == (260, 346, 3), "grey thrice"
    assert camera.reading["rx_deg"] == pytest.approx(3.0, abs=0.3)
    assert camera.reading["depth_mm"] == pytest.approx(3.0, abs=0.1)
    camera.disconnect()
    wrong = plugin.PalpateCamera(plugin.PalpateCameraConfig(**config | {"markers": 8}))
    with pytest.raises(ConnectionError) as left:
        wrong.connect()
    check_values(str(left.value), "markers", 8)


def test_lerobot_itself_makes_the_camera_of_its_type(plugin):
    """By its registry of types and its convention of names; only where LeRobot is installed."""
    if not hasattr(sys.modules.get("lerobot"), "__path__"):
        pytest.skip("lerobot is not installed, and needs another torch: pip install --no-deps lerobot draccus")
    from lerobot.cameras import CameraConfig, make_cameras_from_configs

    config = plugin.PalpateCameraConfig(source="0", fps=30)
    assert config.type == "palpate"
    assert CameraConfig.get_choice_class("palpate") is plugin.PalpateCameraConfig
    made = make_cameras_from_configs({"finger": config})["finger"]
    assert type(made) is plugin.PalpateCamera
    assert made.fps == 30
