"""When a sensor that was learnt from a recording says that a pose is beyond what it learnt from."""

import cv2
import numpy as np
import pytest

from palpate.learn import Prediction, RecordedModel
from palpate.learn.ensemble import Ensemble
from palpate.sensor import Flag
from palpate.sensor.recorded_sensor import RecordedSensor
from palpate.vision import Correspondence, MatchFault

WIDTH = np.array([0.3, 0.2])


def model(reads_markers: bool) -> RecordedModel:
    """A model of poses from -1 to 1 that reads by dots as well, or by pictures alone."""
    by = Ensemble(("picture-ridge",), np.ones((1, 2)), WIDTH)
    outputs = (("rx", "deg", "rx"), ("ry", "deg", "ry"))
    about = {"range": [[-1.0, -1.0], [1.0, 1.0]]}
    dots = Ensemble(("dots-ridge",), np.ones((1, 2)), 0.01 * WIDTH) if reads_markers else None
    return RecordedModel(None, None, (), {}, dots, by, np.full(2, np.inf), outputs, about)


@pytest.mark.parametrize("error", [np.linalg.LinAlgError("singular"), cv2.error("size"), KeyError("x")])
def test_an_image_that_breaks_a_library_is_flagged(monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(RecordedModel, "read", fail)
    assert RecordedSensor(model(False)).read(np.zeros((4, 4))).flags == (Flag.UNREADABLE,)


@pytest.mark.parametrize("reads_markers", [False, True])
@pytest.mark.parametrize(("pose", "outside"), [((1.2, 0.0), False), ((1.4, 0.0), True), ((0.0, -1.25), True)])
def test_a_pose_by_picture_is_outside_where_its_own_interval_is(
    monkeypatch: pytest.MonkeyPatch, reads_markers: bool, pose: tuple[float, float], outside: bool
) -> None:
    estimate = Prediction(np.array([pose]), WIDTH[None], np.zeros(1, bool))
    rejected = Correspondence(np.zeros((0, 2)), np.zeros(0, int), 0.0, 0.0, MatchFault.NO_DOTS)
    monkeypatch.setattr(RecordedModel, "read", lambda self, image: (estimate, rejected))
    flags = RecordedSensor(model(reads_markers)).read(np.zeros((4, 4))).flags
    assert (Flag.OUT_OF_DISTRIBUTION in flags) is outside
