"""Mutated files at the doors of images, videos, camera files and recordings: read, or refused in a sentence."""

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest
from pydantic import ValidationError

from palpate.camera import open_source, read_calibration, read_image
from palpate.core import PalpateError
from palpate.datasets import read_recording

IMAGES = np.random.default_rng(1).integers(0, 255, (24, 16, 20), np.uint8)
POSES = np.random.default_rng(2).uniform(-9, 9, (24, 2))
YAML = (
    "%YAML:1.0\n---\nimage_width: 346\nimage_height: 260\ncamera_matrix: !!opencv-matrix\n"
    "   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 300., 0., 170., 0., 300., 128., 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n"
    "   cols: 5\n   dt: d\n   data: [ -0.3, 0.1, 0.001, -0.0004, 0. ]\n"
)
XML = (
    '<?xml version="1.0"?>\n<opencv_storage><image_width>346</image_width><image_height>260</image_height>\n'
    '<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt><data>300 0 170 0 300 128 0 0 1'
    "</data></camera_matrix>\n"
    "<distortion_coefficients><data>-0.3 0.1 0.001 -0.0004 0</data></distortion_coefficients>"
    "</opencv_storage>\n"
)
INI = (
    "[image]\n\nwidth\n346\n\nheight\n260\n\n[camera]\n\ncamera matrix\n300 0 170\n0 300 128\n0 0 1\n\n"
    "distortion\n-0.3 0.1 0 0 0\n"
)
JSON = (
    '{"camera_matrix": [[300, 0, 170], [0, 300, 128], [0, 0, 1]], "dist_coeff": [[-0.3, 0.1, 0, 0, 0]], '
    '"image_size": [346, 260]}'
)


def write_h5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["images"], file["rx_deg"], file["depth_mm"] = IMAGES, POSES[:, 0], POSES[:, 1]
        file["press"] = np.arange(24) // 3


def write_npz(path: Path) -> None:
    np.savez(path, images=IMAGES, rx_deg=POSES[:, 0], depth_mm=POSES[:, 1], press=np.arange(24) // 3)


def write_video(path: Path) -> None:
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, (20, 16), isColor=False)
    for image in IMAGES[:4]:
        video.write(image)
    video.release()


def play(path: Path) -> None:
    with open_source(str(path)) as source:
        for item in source.images():
            if isinstance(item, PalpateError):
                raise item


def read_all(path: Path) -> None:
    recording = read_recording(path)
    for item in recording.images.read(range(len(recording))):
        if isinstance(item, PalpateError):
            raise item


DOORS: dict[str, tuple[Callable[[Path], object], Callable[[Path], object]]] = {
    **{
        f"a.{ending}": (lambda path: cv2.imwrite(str(path), IMAGES[0]), read_image)
        for ending in ("png", "jpg", "tif", "bmp")
    },
    "a.yaml": (lambda path: path.write_text(YAML), read_calibration),
    "a.xml": (lambda path: path.write_text(XML), read_calibration),
    "a.ini": (lambda path: path.write_text(INI), read_calibration),
    "a.json": (lambda path: path.write_text(JSON), read_calibration),
    "a.avi": (write_video, play),
    "a.h5": (write_h5, read_all),
    "a.npz": (write_npz, read_all),
}


def mutate(content: bytes, random: np.random.Generator) -> bytes:
    """The content with bytes changed, cut off, doubled or removed."""
    data = bytearray(content)
    kind, at = random.integers(5), int(random.integers(len(data)))
    many = int(random.integers(1, 40))
    if kind == 0:
        for place in random.integers(0, len(data), many):
            data[place] = int(random.integers(256))
    elif kind == 1:
        del data[at:]
    elif kind == 2:
        data[at:at] = data[at : at + many]
    elif kind == 3:
        del data[at : at + many]
    else:
        data[at] ^= 1 << int(random.integers(8))
    return bytes(data)


def faults(name: str, count: int, folder: Path, seed: int) -> list[str]:
    """Outcomes of mutations of a file that are neither a value nor a sentence."""
    write, read = DOORS[name]
    path, random, found = folder / name, np.random.default_rng([seed, *name.encode()]), []
    write(path)
    read(path)
    content = path.read_bytes()
    for number in range(count):
        path.write_bytes(mutate(content, random))
        try:
            read(path)
        except (PalpateError, ValidationError) as error:
            text = str(error)
            if len(text) < 20 or "Traceback" in text:
                found.append(f"{name} {number}: {text}")
        except Exception as error:  # the fault that is looked for
            found.append(f"{name} {number}: {type(error).__name__}: {error}")
    return found


@pytest.mark.parametrize("name", DOORS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_mutated_file_is_read_or_refused_in_a_sentence(name: str, tmp_path: Path) -> None:
    assert faults(name, 12, tmp_path, 0) == []


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        each = int(sys.argv[1])
        bad = [fault for door in DOORS for fault in faults(door, each, Path(place), 1)]
        print(f"{each * len(DOORS)} mutations, {len(bad)} faults", *bad[:40], sep="\n")
