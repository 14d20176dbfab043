"""Images from folders, videos, recordings of event cameras and cameras, and how each of them may end."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.camera import open_source
from palpate.camera.sources.numbered_camera import CameraSource
from palpate.core import PalpateError, generator


def grey(level, size=(64, 48)):
    return np.full((size[1], size[0]), level, np.uint8)


def write_video(path, images=12):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, (64, 48))
    dirt = generator(0, "dirt").integers(-40, 40, (48, 64))
    for number in range(images):
        image = np.clip(grey(40 + 4 * number) + dirt, 0, 255).astype(np.uint8)
        writer.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


def test_a_folder_gives_images_by_name_and_an_error_in_the_place_of_a_bad_one(tmp_path):
    for number in (2, 1):
        cv2.imwrite(str(tmp_path / f"{number}.png"), grey(50 * number))
    (tmp_path / "3.png").write_bytes((tmp_path / "2.png").read_bytes()[:40])
    with open_source(str(tmp_path)) as source:
        one, two, three = source.images()
    assert (one[0, 0], two[0, 0]) == (50, 100)
    assert isinstance(three, PalpateError)


def test_a_video_gives_its_images_in_order(tmp_path):
    with open_source(str(write_video(tmp_path / "v.avi"))) as source:
        levels = [int(image.mean()) for image in source.images()]
    assert np.allclose(levels, 40 + 4 * np.arange(12), atol=3)


def test_a_video_that_is_cut_off_ends_with_an_error_and_not_before(tmp_path):
    whole = write_video(tmp_path / "v.avi", 40).read_bytes()
    (tmp_path / "cut.avi").write_bytes(whole[: len(whole) // 2])
    with open_source(str(tmp_path / "cut.avi")) as source:
        images = list(source.images())
    assert isinstance(images[-1], PalpateError)
    assert not any(isinstance(image, PalpateError) for image in images[:-1])
    assert 5 < len(images) < 40


@pytest.mark.parametrize("content", [b"", b"no video at all" * 50])
def test_a_file_that_is_no_video_is_refused(tmp_path, content):
    (tmp_path / "v.mp4").write_bytes(content)
    with refused("source-not-opened"):
        open_source(str(tmp_path / "v.mp4"))


def test_what_is_not_there_is_refused_with_a_remedy(tmp_path):
    with refused("file-missing"):
        open_source(str(tmp_path / "v.mp4"))
    with refused("folder-missing"):
        open_source(str(tmp_path / "none"))
    (tmp_path / "v.txt").write_text("x")
    with refused("video-format-unknown"):
        open_source(str(tmp_path / "v.txt"))
    with refused("source-not-opened", "synthetic"):
        open_source("987")


class Unplugged:
    """A camera as OpenCV gives it, which is pulled out after three images and one hiccup."""

    def __init__(self, size=(64, 48)):
        self.left = [grey(1), None, grey(2), grey(3)]
        self.size, self.released = size, False

    def isOpened(self):  # noqa: N802  (OpenCV's name)
        return True

    def read(self):
        image = self.left.pop(0) if self.left else None
        return image is not None, image

    def get(self, what):
        return self.size[0] if what == cv2.CAP_PROP_FRAME_WIDTH else self.size[1]

    def release(self):
        self.released = True


def test_a_camera_that_is_unplugged_ends_with_an_error_and_does_not_hang(monkeypatch):
    camera = Unplugged()
    monkeypatch.setattr(cv2, "VideoCapture", lambda _: camera)
    with CameraSource("0") as source:
        images = list(source.images())
    assert [image[0, 0] for image in images[:3]] == [1, 2, 3]
    assert isinstance(images[3], PalpateError)
    assert images[3].code == "camera-gone"
    assert camera.released


def test_a_camera_whose_images_would_fill_the_memory_is_refused(monkeypatch):
    camera = Unplugged((20_000, 20_000))
    monkeypatch.setattr(cv2, "VideoCapture", lambda _: camera)
    with refused("image-too-large", "20000"):
        open_source("0")
    assert camera.released


def test_an_event_cameras_recording_gives_its_images(tmp_path):
    dv = needs("dv_processing")
    path = tmp_path / "r.aedat4"
    writer = dv.io.MonoCameraWriter(str(path), dv.io.MonoCameraWriter.FrameOnlyConfig("DAVIS346", (64, 48)))
    for number in range(5):
        writer.writeFrame(dv.Frame(1_000_000 + 100_000 * number, grey(40 * number)))
    del writer
    with open_source(str(path)) as source:
        assert [image[0, 0] for image in source.images()] == [0, 40, 80, 120, 160]
    (tmp_path / "cut.aedat4").write_bytes(path.read_bytes()[:300])
    with refused("recording-unreadable"):
        open_source(str(tmp_path / "cut.aedat4"))


def test_a_recording_of_events_alone_is_refused(tmp_path, monkeypatch):
    from palpate.camera.sources import event_recording

    (tmp_path / "r.aedat4").write_bytes(b"")
    only_events = SimpleNamespace(isFrameStreamAvailable=lambda: False)
    dv = SimpleNamespace(io=SimpleNamespace(MonoCameraRecording=lambda _: only_events))
    monkeypatch.setattr(event_recording, "load_extra", lambda *_: dv)
    with refused("recording-no-images"):
        open_source(str(tmp_path / "r.aedat4"))
