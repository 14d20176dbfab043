"""Every reader of recordings of the package, one row each."""

import csv
import json
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest

from needs import needs
from palpate.testing import RecordingReaderSuite

COUNT = 24
RNG = np.random.default_rng(0)
POSES = RNG.uniform(-5, 5, (COUNT, 2))
IMAGES = RNG.integers(0, 255, (COUNT, 48, 64), np.uint8)
PRESSES = np.arange(COUNT) // 3


class TestTable(RecordingReaderSuite):
    @pytest.fixture
    def place(self, tmp_path: Path) -> Path:
        for number, image in enumerate(IMAGES):
            cv2.imwrite(str(tmp_path / f"{number}.png"), image)
        with (tmp_path / "poses.csv").open("w", newline="") as file:
            table = csv.writer(file)
            table.writerow(["image", "press", "rx_deg", "ry_deg"])
            table.writerows([f"{k}.png", PRESSES[k], *POSES[k]] for k in range(COUNT))
        return tmp_path / "poses.csv"

    @pytest.fixture
    def damaged(self, tmp_path: Path) -> Path:
        (tmp_path / "torn.csv").write_bytes(b"image,rx_deg\n\xff\xfe\xfa")
        return tmp_path / "torn.csv"


class TestHDF5(RecordingReaderSuite):
    @pytest.fixture
    def place(self, tmp_path: Path) -> Path:
        with h5py.File(tmp_path / "presses.h5", "w") as file:
            file["images"], file["press"] = IMAGES, PRESSES
            file["pose"] = POSES
            file["pose"].attrs["columns"] = ["rx_deg", "ry_deg"]
        return tmp_path / "presses.h5"

    @pytest.fixture
    def damaged(self, tmp_path: Path) -> Path:
        (tmp_path / "torn.h5").write_bytes(b"\x89HDF torn")
        return tmp_path / "torn.h5"


class TestLeRobot(RecordingReaderSuite):
    @pytest.fixture
    def place(self, tmp_path: Path) -> Path:
        parquet, arrow = needs("pyarrow.parquet"), needs("pyarrow")
        features = {
            "camera": {"dtype": "image"},
            "observation.state": {"dtype": "float32", "names": ["rx_deg", "ry_deg"]},
            "episode_index": {"dtype": "int64"},
        }
        (tmp_path / "meta").mkdir()
        (tmp_path / "data").mkdir()
        (tmp_path / "meta" / "info.json").write_text(json.dumps({"features": features, "fps": 10}))
        cells = [
            {"bytes": cv2.imencode(".png", image)[1].tobytes(), "path": f"{k}.png"} for k, image in enumerate(IMAGES)
        ]
        table = arrow.table({"camera": cells, "observation.state": POSES.tolist(), "episode_index": PRESSES})
        parquet.write_table(table, tmp_path / "data" / "file-000.parquet")
        return tmp_path

    @pytest.fixture
    def damaged(self, tmp_path: Path) -> Path:
        needs("pyarrow")
        (tmp_path / "torn" / "meta").mkdir(parents=True)
        (tmp_path / "torn" / "meta" / "info.json").write_text("{")
        return tmp_path / "torn"
