"""The live page's sensor: from a source to a verdict."""

import math
from itertools import islice
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from made_up_presses import MESH, made_up_press, rows

from errors import check_values, refused

pytest.importorskip("PIL")


from made_up_readings import make_fit, make_reading
from palpate.camera import Source, open_source
from palpate.core import PalpateError
from palpate.core.report import csv_text
from palpate.design import TILT_SPACE, Design, MarkerSpec, place_markers
from palpate.learn import Prediction
from palpate.sensor import Unit
from palpate.simulation import SimulatedSource, sample_presses
from palpate.viewer.dial import draw_dial
from palpate.viewer.live import LiveVerdict, open_live, rate_reading, tilt_interval, to_grey
from palpate.viewer.recordings import find_recordings, inside
from palpate.viewer.results import GridDesign

LAYOUT = place_markers(MESH.skin, MarkerSpec(count=19))
DESIGN = GridDesign(0, rows()[1], Design.of_skin(MESH.skin, LAYOUT), ())


class MadeUpPredictor:
    """Reads the mean shift of the markers as a pose."""

    markers, level, space = 19, 0.9, TILT_SPACE

    def predict(self, images_px):
        poses = np.tile([1.0, 2.0, 3.0], (len(images_px), 1))
        return Prediction(poses, np.full(poses.shape, 0.5), np.zeros(len(poses), bool))


class MadeUpSource(Source):
    """Hands on what it was given."""

    def __init__(self, *items):
        self._items = items
        self.closed = False

    @property
    def name(self):
        return "made up"

    def images(self):
        yield from self._items

    def close(self):
        self.closed = True


@pytest.fixture
def touches():
    presses = [made_up_press(tilt) for tilt in (0.0, 3.0, 6.0)]
    return SimulatedSource(Unit(Design.of_skin(MESH.skin, LAYOUT)), sample_presses(presses, seed=1))


def reading(rx=0.0, ry=0.0, half=0.2, touching=True):
    return make_reading([rx, ry, 3.0], [half, half, 0.1], touching, found=19)


@pytest.mark.parametrize(
    ("given", "verdict"),
    [
        (reading(0.5, 0.5), LiveVerdict.GO),
        (reading(3.0, 0.0), LiveVerdict.NO_GO),
        (reading(1.9, 0.0), LiveVerdict.UNSURE),
        (reading(0.0, 0.0, half=math.inf), LiveVerdict.UNSURE),
        (reading(touching=False), LiveVerdict.NO_TOUCH),
        (reading(math.nan, math.nan), LiveVerdict.NO_TOUCH),
    ],
)
def test_a_verdict_counts_the_interval(given, verdict):
    assert rate_reading(given, 2.0) is verdict
    assert draw_dial(given, 2.0, verdict).startswith("<svg")


def test_the_tilt_lies_within_its_interval():
    assert tilt_interval(reading(3.0, 4.0, half=0.0)) == pytest.approx((5.0, 5.0))
    assert tilt_interval(reading(0.1, 0.1, half=0.2)) == pytest.approx((0.0, 0.3 * math.sqrt(2)))


def test_virtual_touches_are_read_back(touches):
    live = open_live(DESIGN, MadeUpPredictor(), touches)
    live.record = []
    steps = [live.step() for _ in range(60)]
    assert all(step.found.mean() > 0.9 for step in steps if step.found.any())
    assert max(float(np.abs(step.positions_px - live.rest_px).max()) for step in steps) > 1
    assert len(live.record) == 60
    assert csv_text(live.record).count("\n") == 61
    truths = np.array([step.truth for step in steps])
    assert len({tuple(truth[:2]) for truth in truths if truth[2] > 0}) == 2  # two touches, by different walls
    assert np.hypot(truths[:, 0], truths[:, 1]).max() <= 6
    assert truths[:, 2].max() == pytest.approx(3.8)


def test_the_truth_is_that_of_the_image_handed_on(touches):
    images = touches.images()
    assert [(next(images).shape, touches.truth) for _ in range(10)] == [((260, 346), (0.0, 0.0, 0.0))] * 10  # at rest
    for step in range(15):
        next(images)
        assert touches.truth[2] == pytest.approx(0.2 * step)
    tilt = np.hypot(*touches.truth[:2])
    assert min(abs(tilt - solved) for solved in (0.0, 3.0, 6.0)) < 1e-9


def test_the_source_is_given_back(touches):
    source = MadeUpSource(*islice(touches.images(), 2))
    live = open_live(DESIGN, MadeUpPredictor(), source)
    assert live.step().truth is None
    assert live.step() is None
    live.close()
    assert source.closed


def test_each_image_is_searched_once_and_drawn_as_it_was_read(touches):
    live, found = open_live(DESIGN, MadeUpPredictor(), touches), []
    detector = live.sensor.detector

    def find(image):
        found.append(detector.find(image))
        return found[-1]

    live.sensor.detector = SimpleNamespace(find=find)
    for number in range(1, 16):
        step = live.step()
        assert len(found) == number
        assert step.positions_px is step.reading.sighting.positions_px
        dots = found[-1].positions_px[step.reading.sighting.blob[step.found]]
        assert np.abs(step.positions_px[step.found] - dots).max() < 1e-9


def test_a_recording_is_replayed_with_its_faults(touches, tmp_path):
    for number, image in enumerate(islice(touches.images(), 4)):
        cv2.imwrite(str(tmp_path / f"{number:03d}.png"), image)
    (tmp_path / "002.png").write_bytes(b"no image")
    live = open_live(DESIGN, MadeUpPredictor(), open_source(str(tmp_path)))
    steps = []
    while (step := live.step()) is not None:
        steps.append(step)
    assert [step.image is None for step in steps] == [False, True, False]
    assert steps[1].reading.reason
    assert not steps[1].found.any()


def test_a_video_is_replayed(touches, tmp_path):
    images = list(islice(touches.images(), 4))
    height, width = images[0].shape
    video = cv2.VideoWriter(str(tmp_path / "touch.avi"), cv2.VideoWriter_fourcc(*"FFV1"), 10, (width, height))
    if not video.isOpened():
        pytest.skip("this OpenCV writes no video")
    for image in images:
        video.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    video.release()
    assert find_recordings(tmp_path) == ("touch.avi",)
    live = open_live(DESIGN, MadeUpPredictor(), open_source(str(inside(tmp_path, "touch.avi"))))
    assert live.size_px == (height, width)
    steps = [live.step() for _ in range(4)]
    assert [step is None for step in steps] == [False, False, False, True]
    assert steps[0].image.shape == (height, width)


@pytest.mark.parametrize("name", ["broken.avi", "empty.mp4"])
def test_a_video_that_cannot_be_opened_is_reported(tmp_path, name):
    (tmp_path / name).write_bytes(b"" if name.startswith("empty") else b"no video")
    with refused("source-not-opened"):
        open_source(str(inside(tmp_path, name)))


def test_a_source_without_an_image_is_refused():
    with refused("source-no-image"):
        open_live(DESIGN, MadeUpPredictor(), MadeUpSource())
    with refused("source-broken"):
        open_live(DESIGN, MadeUpPredictor(), MadeUpSource(PalpateError("It is broken.", code="source-broken")))


@pytest.mark.parametrize(
    "name", ["..", "../other", "/etc", "", ".", "a/../../other", "link", "x\0y", "nothing", "a.txt"]
)
def test_a_recording_cannot_lie_outside_the_result_folder(tmp_path, name):
    folder, other = tmp_path / "results", tmp_path / "other"
    folder.mkdir()
    other.mkdir()
    (folder / "a.txt").write_text("")
    (folder / "link").symlink_to(other)
    with refused("recording-unknown"):
        inside(folder, name)


def test_recordings_are_found_but_not_in_the_store(tmp_path):
    for place in ("one", "runs/two", "store/press", ".hidden"):
        (tmp_path / place).mkdir(parents=True)
        (tmp_path / place / "0.png").write_bytes(b"")
    assert find_recordings(tmp_path) == ("one", "runs/two")
    assert inside(tmp_path, "runs/two") == (tmp_path / "runs" / "two").resolve()


def test_every_kind_of_image_becomes_grey():
    assert to_grey(np.full((2, 2), 65535, np.uint16)).max() == 255
    assert to_grey(np.full((2, 2, 3), 90, np.uint8)).max() == 90


@pytest.mark.parametrize(("inverted", "state"), [(False, ""), (True, "; the skin is inverted")])
def test_a_twin_tells_force_friction_and_how_well_it_fits(inverted, state):
    pytest.importorskip("nicegui")
    from palpate.calibration import Force
    from palpate.viewer.live_page import list_figures

    covariance = np.diag([0.01, 0.01, 0.0025])
    covariance[0, 1] = covariance[1, 0] = -0.005
    force = Force(np.array([0.0, 0.0, 0.4]), 1e-4 * np.eye(3), np.array([0.0, 0.0, 1.0]))
    fit = make_fit([1.0, 2.0, 3.0], covariance, force, misfit=1.2, inverted=inverted)
    read = make_reading(fit.pose, force=force, fit=fit)
    rows = {row[0]: row[1:] for row in list_figures(read, None)}
    assert rows["force"][0] == pytest.approx(0.4)
    assert rows["1/µ"][:2] == pytest.approx((0.8, 1.645 * 0.2), rel=1e-3)
    assert rows["misfit"][0] == 1.2
    check_values(rows["misfit"][3], 1, "rx", "ry", "-0.50")
    assert rows["misfit"][3].endswith(state)
