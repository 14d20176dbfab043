"""A further output needs no line of source: a column of a recording reaches readings, files and pages."""

import csv
from pathlib import Path

import numpy as np

from drawn_tactip import NAMES, DrawnSensor, draw_motions, draw_recording
from needs import needs
from palpate.core import ArtefactStore
from palpate.core.report import page_markdown
from palpate.core.run import Progress
from palpate.datasets import ColumnMapping, read_recording
from palpate.learn import RecordingSpec, read_model, recording_page, train_on_recording, write_model
from palpate.sensor import write_readings
from palpate.sensor.recorded_sensor import RecordedSensor

needs("nicegui")
from palpate.viewer.live_page import list_figures  # noqa: E402

OUTPUTS = ("rx_deg", "ry_deg", "depth_mm", "shear_x_mm")
HELD_OUT = 12


def test_shear_is_estimated_with_its_interval(tmp_path: Path) -> None:
    motions = draw_motions(84, 5, shear=3.0, tilt=10.0)
    for name, some in (("train", motions[HELD_OUT:]), ("test", motions[:HELD_OUT])):
        draw_recording(tmp_path / name, some, DrawnSensor(rings=3), told=NAMES[:4])
    columns = ColumnMapping(targets=OUTPUTS)
    spec = RecordingSpec(estimators="ridge", threads=1)
    result = train_on_recording(
        read_recording(tmp_path / "train", columns), spec, ArtefactStore(tmp_path / "store"), Progress()
    )
    assert "shear_x" in page_markdown(recording_page(result))
    write_model(tmp_path / "model.h5", result.model)

    sensor = RecordedSensor(read_model(tmp_path / "model.h5"))
    test = read_recording(tmp_path / "test", columns)
    images = list(test.images.read(range(len(test))))
    readings = list(write_readings(tmp_path / "live.csv", map(sensor.read, images), sensor.model.space))
    error = np.array([one["shear_x_mm"] for one in readings]) - test.targets[:, 3]
    half = np.array([one.half_width[3] for one in readings])
    assert np.sqrt(np.mean(error**2)) < 0.5 * motions[:, 3].std()
    assert np.mean(np.abs(error) < half) > 0.6

    with (tmp_path / "live.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["shear_x_mm"]) for row in rows] == [one["shear_x_mm"] for one in readings]
    assert [float(row["shear_x_half_width_mm"]) for row in rows] == half.tolist()
    figures = {
        name: (value, half_width, unit) for name, value, half_width, unit, _ in list_figures(readings[0], None)
    }
    assert figures["shear_x"] == (readings[0]["shear_x_mm"], half[0], "mm")
