"""A recording is taken by a robot that stops, with a camera that fails, in a process that is killed."""

import csv
import io
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from errors import check_refusal, refused
from palpate.camera import Source
from palpate.cli import main
from palpate.core import PalpateError
from palpate.design import DomeSpec, build_skin
from palpate.rig import Acquisition, ManualRobot, PressFrame, RecordingFolder, TakeSpec, find_image_fault, images_of
from palpate.sensor import Placement, Robot, rotation_from_vector
from palpate.simulation import SimulatedRobot
from palpate.simulation.simulated_cell import SimulatedCell
from small_chain import write_small_twin

SKIN = build_skin(DomeSpec())
SPEC = TakeSpec(tilts=2, azimuths=3, depths=2, dwell_s=0.0, tool_length=100.0, rest_images=2)
START = Placement(rotation_from_vector(np.array([20.0, -30.0, 50.0])), np.array([300.0, -200.0, 80.0]))
IMAGES = 2 + 6 * 2


class TestRig(Robot):
    """Robot and camera that note every pose; each fails at the calls that it is given."""

    __test__ = False

    def __init__(self, *, camera_fails: int = -1, robot_fails: int = -1) -> None:
        self.pose, self.moves, self.images = START, 0, 0
        self.camera_fails, self.robot_fails = camera_fails, robot_fails

    def move(self, base_from_flange: Placement) -> None:
        self.moves += 1
        if self.robot_fails in range(self.moves + 1):
            raise PalpateError("The robot does not answer.", "Check it.", code="robot-lost")
        self.pose = base_from_flange

    def flange_pose(self) -> Placement:
        return self.pose

    def next_image(self) -> NDArray[Any] | PalpateError:
        self.images += 1
        if self.camera_fails in range(self.images + 1):
            return PalpateError("The camera sends no more images.", code="camera-gone")
        noise: NDArray[np.uint8] = np.random.default_rng().integers(0, 250, (12, 16), np.uint8)
        return noise


def take(folder: Path, rig: TestRig, next_image: Callable[[], Any] | None = None) -> Acquisition:
    grid = SPEC.grid()
    recording = RecordingFolder(folder, SPEC.model_dump(mode="json"))
    acquisition = Acquisition(rig, next_image or rig.next_image, SKIN, recording, SPEC)
    acquisition.take(len(grid), grid.__getitem__)
    return acquisition


def check_whole(folder: Path, images: int) -> list[dict[str, str]]:
    """The rows of a recording: each image once, in its file; nothing else is left in the folder."""
    rows = list(csv.DictReader((folder / "poses.csv").open(encoding="utf-8")))
    names = [row["image"] for row in rows]
    assert len(names) == len(set(names)) == images
    assert all(cv2.imread(str(folder / name), cv2.IMREAD_UNCHANGED) is not None for name in names)
    assert {path.name for path in folder.iterdir()} == {*names, "poses.csv", "recording.json"}
    poses = [tuple(row[name] for name in ("rx_deg", "ry_deg", "depth_mm")) for row in rows if row["press"] != "rest"]
    assert len(set(poses)) == len(poses)
    return rows


def test_poses_and_flanges_are_inverse() -> None:
    frame = PressFrame(START, SKIN, Placement(rotation_from_vector(np.array([0, 3.0, 9])), np.array([0, 5.0, 100])))
    assert frame.pose_at(START) == pytest.approx(np.zeros(3), abs=1e-9)
    for pose in ([0.0, 0.0, -3.0], [7.0, -4.0, 2.0], [-3.0, 9.0, 5.5]):
        assert frame.pose_at(frame.flange_at(np.array(pose))) == pytest.approx(pose, abs=1e-9)


def test_a_recording_has_its_poses_and_ends_clear_of_the_wall(tmp_path: Path) -> None:
    rig = TestRig()
    take(tmp_path / "new", rig)
    rows = check_whole(tmp_path / "new", IMAGES)
    tilts = {round(float(np.hypot(float(row["rx_deg"]), float(row["ry_deg"]))), 6) for row in rows[2:]}
    assert tilts == {5.0, 10.0}
    assert {float(row["depth_mm"]) for row in rows[2:]} == {1.0, 4.0}
    frame = PressFrame(START, SKIN, Placement(position=np.array([0.0, 0.0, 100.0])))
    assert frame.pose_at(rig.pose)[2] == pytest.approx(-SPEC.clear)


@pytest.mark.parametrize("call", range(1, IMAGES + 1, 3))
def test_a_lost_camera_or_robot_costs_no_image(tmp_path: Path, call: int) -> None:
    with refused("camera-gone"):
        take(tmp_path, rig := TestRig(camera_fails=call))
    frame = PressFrame(START, SKIN, Placement(position=np.array([0.0, 0.0, 100.0])))
    assert frame.pose_at(rig.pose)[2] < 0
    stopped = TestRig(robot_fails=2)
    with refused("robot-lost"):
        take(tmp_path, stopped)
    assert stopped.moves == 2
    again = TestRig()
    take(tmp_path, again)
    check_whole(tmp_path, IMAGES)
    assert again.images <= IMAGES - (call - 1)


def test_a_draft_of_a_killed_process_is_removed(tmp_path: Path) -> None:
    with refused("camera-gone"):
        take(tmp_path, TestRig(camera_fails=6))
    (tmp_path / ".writing-left").mkdir()
    (tmp_path / ".writing-left" / "press_000_00.png").write_bytes(b"half")
    take(tmp_path, TestRig())
    check_whole(tmp_path, IMAGES)


@pytest.mark.parametrize("value", [0, 255])
def test_a_bad_image_is_taken_again_once(tmp_path: Path, value: int) -> None:
    rig = TestRig()
    bad = [np.full((12, 16), value, np.uint8)]
    take(tmp_path, rig, lambda: bad.pop() if rig.images == 4 and bad else rig.next_image())
    check_whole(tmp_path, IMAGES)


@pytest.mark.parametrize("value", [0, 255])
def test_two_bad_images_stop_the_recording(tmp_path: Path, value: int) -> None:
    rig = TestRig()
    with refused("image-rejected"):
        take(tmp_path, rig, lambda: np.full((12, 16), value, np.uint8) if rig.images == 4 else rig.next_image())


def test_a_frozen_camera_stops_the_recording(tmp_path: Path) -> None:
    frozen = TestRig().next_image()
    with refused("image-rejected"):
        take(tmp_path, TestRig(), lambda: frozen)
    assert len(list(tmp_path.glob("press_*.png"))) == 1


def test_other_settings_and_other_folders_are_refused(tmp_path: Path) -> None:
    take(tmp_path / "new", TestRig())
    with refused("recording-settings-differ", "tilts"):
        RecordingFolder(tmp_path / "new", SPEC.model_copy(update={"tilts": 4}).model_dump(mode="json"))
    with refused("folder-exists"):
        RecordingFolder(tmp_path, {})
    (tmp_path / "recording.json").write_text("{}")
    with refused("recording-settings-differ"):
        RecordingFolder(tmp_path, {"tilts": 4})


class NumberedSource(Source):
    live = True

    @property
    def name(self) -> str:
        return "numbers"

    def images(self) -> Iterator[NDArray[np.uint8]]:
        for number in range(5):
            yield np.full((2, 2), number, np.uint8)


def test_buffered_images_of_a_live_camera_are_discarded() -> None:
    following = images_of(NumberedSource(), 3)
    first, second = following(), following()
    assert isinstance(first, np.ndarray)
    assert first[0, 0] == 3
    assert isinstance(second, PalpateError)


def test_a_manual_robot_asks_for_each_pose(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n"))
    robot, there = ManualRobot(), Placement(position=np.ones(3))
    robot.announce("rx 3.000°")
    robot.move(there)
    assert "rx 3.000°" in capsys.readouterr().err
    assert robot.flange_pose() is there
    with refused("robot-lost"):
        robot.move(Placement())


KILLED = """
import os, signal, sys
from palpate.rig import recording_folder
from palpate.cli import main
write = recording_folder.write_csv
def write_and_die(path, rows, columns):
    if len(rows) == int(sys.argv[1]):
        os.kill(os.getpid(), signal.SIGKILL)
    write(path, rows, columns)
recording_folder.write_csv = write_and_die
main(sys.argv[2:])
"""


def run(*words: str) -> Any:
    with pytest.raises(SystemExit) as left:
        main(words)
    return left.value.code


def recorded(folder: Path) -> int:
    return len((folder / "poses.csv").read_text(encoding="utf-8").splitlines()) - 1


@pytest.mark.slow(60)
def test_sixty_presses_survive_a_kill_a_lost_camera_and_a_lost_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Taken by the command line on the simulated rig, and read by the three commands that read recordings."""
    folder, twin = tmp_path / "taken", write_small_twin(tmp_path / "twin.h5")
    reads = ("--model", str(twin), "--markers", "37")
    words = ("recording", "take", str(folder), "--robot", "simulated", *reads, "--depth", "3.5", "--dwell", "0")
    killed = subprocess.run([sys.executable, "-c", KILLED, "60", *words], env=os.environ, check=False)
    assert killed.returncode == -9
    assert recorded(folder) == 59
    calls = iter(range(50))
    with monkeypatch.context() as lost:
        image = SimulatedCell.next_image
        gone = PalpateError("Camera 0 sends no more images.", code="camera-gone")
        lost.setattr(SimulatedCell, "next_image", lambda cell: gone if next(calls, None) is None else image(cell))
        assert run(*words) == 2
    assert recorded(folder) == 109
    moves = iter(range(90))
    with monkeypatch.context() as lost:
        move = SimulatedRobot.move

        def stop(robot: SimulatedRobot, pose: Placement) -> None:
            if next(moves, None) is None:
                raise PalpateError("The robot does not answer.", "Check it.", code="robot-lost")
            move(robot, pose)

        lost.setattr(SimulatedRobot, "move", stop)
        assert run(*words) == 2
    assert 109 < recorded(folder) < 245
    assert run(*words) == 0
    rows = check_whole(folder, 245)
    assert len({row["press"] for row in rows} - {"rest"}) == 60
    table = str(folder / "poses.csv")
    assert run("calibration", "identify", table, *reads, "--out", str(tmp_path / "unit.json")) == 0
    known = ("--unit", str(tmp_path / "unit.json"), "--no-zero", "--min-depth", "1")
    assert run("calibration", "accept", table, *reads, *known) == 0
    assert run("recording", "train", str(folder), "--estimators", "ridge", "--out", str(tmp_path / "model")) == 0
    planned = tmp_path / "planned"
    assert run(*words[:2], str(planned), *words[3:], "--next", "3", "--depths", "2", "--max-tilt", "12") == 0
    chosen = json.loads((planned / "recording.json").read_text(encoding="utf-8"))["plan"]["presses"]
    assert len({tuple(press) for press in chosen}) == 3
    check_whole(planned, 5 + 3 * 2)
    capsys.readouterr()


@pytest.mark.parametrize("changes", [{"depth": 40.0}, {"max_tilt_deg": 30.0, "depth": 13.0}])
def test_a_depth_at_which_the_wall_reaches_the_rim_is_refused_before_a_move(
    tmp_path: Path, changes: dict[str, float]
) -> None:
    rig, spec = TestRig(), SPEC.model_copy(update=changes)
    with refused("take-reaches-rim"):
        Acquisition(rig, rig.next_image, SKIN, RecordingFolder(tmp_path, {}), spec)
    assert rig.moves == 0


def test_a_long_tool_stays_clear_on_straight_lines_between_presses(tmp_path: Path) -> None:
    spec = TakeSpec(dwell_s=0.0, tool_length=300.0, rest_images=1, depths=1, max_tilt_deg=20.0)
    frame = PressFrame(START, SKIN, Placement(position=np.array([0.0, 0.0, 300.0])))
    deepest: list[float] = []

    class StraightRobot(TestRig):
        def move(self, base_from_flange: Placement) -> None:
            turn = Rotation.from_matrix([self.pose.rotation, base_from_flange.rotation])
            for share in np.linspace(0.0, 1.0, 21):
                between = self.pose.position + share * (base_from_flange.position - self.pose.position)
                rotation = Slerp([0.0, 1.0], turn)(share).as_matrix()
                deepest.append(frame.pose_at(Placement(rotation, between))[2])
            if deepest[-21] < 0.0 > deepest[-1]:
                assert max(deepest[-21:]) < 0.0
            super().move(base_from_flange)

    rig = StraightRobot()
    acquisition = Acquisition(rig, rig.next_image, SKIN, RecordingFolder(tmp_path, {}), spec)
    presses = [(20.0, 0.0), (20.0, 180.0), (20.0, 90.0), (20.0, -60.0)]
    acquisition.take(len(presses), presses.__getitem__)
    assert max(deepest) == pytest.approx(spec.depth, abs=1e-6)


@pytest.mark.parametrize("turn_deg", [30.0, 120.0])
def test_a_sensor_far_from_its_start_is_not_moved(tmp_path: Path, turn_deg: float) -> None:
    take(tmp_path / "one", TestRig())
    rig = TestRig()
    away = START.rotation @ rotation_from_vector(np.array([turn_deg, 0.0, 0.0]))
    recording = RecordingFolder(tmp_path / "two", {})
    acquisition = Acquisition(rig, rig.next_image, SKIN, recording, SPEC)
    rig.pose = Placement(away, START.position - 300.0 * away[:, 2])
    with refused("robot-far"):
        acquisition.take(1, lambda _: (5.0, 0.0))
    assert rig.moves == 0


def test_a_robot_that_does_not_report_its_pose_is_not_moved_again(tmp_path: Path) -> None:
    class SilentRobot(TestRig):
        silent = False

        def flange_pose(self) -> Placement:
            if self.silent:
                raise PalpateError("The robot does not answer.", "Check it.", code="robot-lost")
            return super().flange_pose()

        def next_image(self) -> NDArray[Any] | PalpateError:
            self.silent = self.images == SPEC.rest_images
            return super().next_image()

    rig = SilentRobot()
    with refused("robot-lost"):
        take(tmp_path, rig)
    assert rig.moves == 3  # clear of the wall, tilted, first depth


def test_depths_ascend_and_one_depth_is_the_last() -> None:
    assert TakeSpec(depths=1, depth=4.0).depths_mm.tolist() == [4.0]
    assert TakeSpec(depths=4, min_depth=1.0, depth=4.0).depths_mm == pytest.approx([1.0, 2.0, 3.0, 4.0])
    with refused("take-depths-fall"):
        TakeSpec(min_depth=5.0, depth=4.0)


def test_a_recording_of_one_robot_is_not_continued_by_another(tmp_path: Path) -> None:
    RecordingFolder(tmp_path, {"robot": "manual"}).write_plan()
    with refused("recording-settings-differ", "robot"):
        RecordingFolder(tmp_path, {"robot": "arm"})


def test_an_image_of_floats_is_refused() -> None:
    assert find_image_fault(np.random.default_rng(0).uniform(size=(8, 8)), None, SPEC)


@pytest.mark.parametrize("bits", [10, 12, 14, 16])
def test_an_image_of_fewer_bits_than_its_type_is_checked_by_its_own_range(bits: int) -> None:
    top = 2**bits - 1
    ramp = np.linspace(0, top, 64).reshape(8, 8).astype(np.uint16)
    assert not find_image_fault(ramp, None, SPEC)
    assert find_image_fault(np.where(ramp < 0.7 * top, top, ramp).astype(np.uint16), None, SPEC)
    assert find_image_fault((0.6 * top + 0.001 * ramp).astype(np.uint16), None, SPEC)


@pytest.mark.parametrize(("level", "noise"), [(16, 4), (64, 4), (64, 16), (400, 15)])
def test_a_covered_lens_is_blank_in_16_bits(level: int, noise: int) -> None:
    dark = np.clip(np.random.default_rng(0).normal(level, noise, (480, 640)).round(), 0, None).astype(np.uint16)
    assert find_image_fault(dark, None, SPEC)


@pytest.mark.parametrize(
    ("robot", "code"), [("tcp:127.0.0.1:1", "robot-lost"), ("ur:", "robot-address"), ("nobody", "kind-unknown")]
)
def test_a_robot_that_cannot_be_opened_is_refused_before_the_camera(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], robot: str, code: str
) -> None:
    with pytest.raises(SystemExit) as left:
        main(["recording", "take", str(tmp_path / "new"), "--robot", robot, "--source", "no_camera.mp4"])
    assert left.value.code == 2
    check_refusal(capsys.readouterr().err, code, robot.rpartition(":")[0] and robot.partition(":")[2])
