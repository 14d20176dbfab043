"""From a drawn recording to a model: what it reads, what it says of itself, and of hostile recordings."""

import csv
import json
import os
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

import cv2
import numpy as np
import pytest

from drawn_gel import DrawnGel, draw_gel_recording
from drawn_tactip import NAMES, DrawnSensor, DrawnTruth, another_unit, draw_motions, draw_recording
from errors import refused
from needs import needs
from palpate.cli import main
from palpate.core import ArtefactStore, PalpateError
from palpate.core.report import page_markdown
from palpate.core.run import Progress
from palpate.datasets import Normalisation, read_recording
from palpate.learn import (
    ESTIMATORS,
    Estimator,
    ImageNetwork,
    PretrainedModel,
    RecordingResult,
    RecordingSpec,
    RotationAugmentation,
    TrainingJob,
    TrainingRun,
    TrainingSet,
    prepare_recording,
    read_model,
    recording_page,
    recording_report,
    train_members,
    train_on_recording,
    write_estimator,
    write_model,
)
from palpate.learn.member import ImageRidge, MarkerRidge
from palpate.learn.prepare_recording import PreparedRecording
from palpate.learn.train_on_recording import plan_jobs
from presses import copy_learnt_sensor

SENSOR = DrawnSensor(rings=4)
COUNT = 64
FAST = RecordingSpec(estimators="ridge", threads=1)


class Said(Progress):
    """Keeps what is begun, and the texts of advances."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []

    def begin(self, what: str, cost: float = 1.0, done: float = 0.0) -> None:
        super().begin(what, cost, done)
        self.texts.append(what)

    def advance(self, what: str, done: float, text: str = "") -> None:
        super().advance(what, done, text)
        self.texts.append(f"{what}: {text}")


def learn(folder: Path, spec: RecordingSpec = FAST, start: PretrainedModel | None = None) -> RecordingResult:
    return train_on_recording(read_recording(folder), spec, ArtefactStore(folder / "store"), Progress(), start)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, DrawnTruth]:
    folder = tmp_path_factory.mktemp("drawn")
    return folder, draw_recording(folder, draw_motions(COUNT, 1, shear=3.0), SENSOR)


@pytest.fixture(scope="module")
def learnt(drawn: tuple[Path, DrawnTruth]) -> RecordingResult:
    return learn(drawn[0])


@pytest.fixture
def copied(drawn: tuple[Path, DrawnTruth], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy to damage. Its images are read at 16 px only, the least of the sizes that `learnt` chooses from."""
    monkeypatch.setattr(ImageRidge, "sides", (16,))
    shutil.copytree(drawn[0], tmp_path / "copy")
    return tmp_path / "copy"


def prepare(folder: Path) -> PreparedRecording:
    return prepare_recording(read_recording(folder), FAST, ArtefactStore(folder / "store"), Progress())


def change_table(folder: Path, change: Callable[[list[list[str]]], list[list[str]]]) -> Path:
    path = folder / "poses.csv"
    head, *rows = csv.reader(path.read_text().splitlines())
    path.write_text("\n".join(",".join(row) for row in [head, *change(rows)]) + "\n")
    return folder


def test_a_recording_is_learnt_far_better_than_by_the_mean(learnt: RecordingResult) -> None:
    best = next(score for score in learnt.scores if score.name == learnt.best)
    assert best.errors[0].rmse < 5.0
    assert best.errors[1].rmse < 5.0
    assert best.errors[2].rmse < 1.1
    assert all(0.6 < inside <= 1 for inside in best.coverage)


def test_most_correspondences_are_right_against_what_was_drawn(
    learnt: RecordingResult, drawn: tuple[Path, DrawnTruth]
) -> None:
    assigned, truth = learnt.seen.assigned, drawn[1]
    assert assigned is not None
    rest = assigned.layout.rest_px
    own = np.argmin(np.linalg.norm(rest[:, None] - truth.rest[None], axis=-1), axis=1)
    off = np.linalg.norm(rest + assigned.moved_px[:COUNT] - truth.heads[:, own], axis=-1)
    right = (off < 3) & assigned.found[:COUNT]
    assert right[truth.seen[:, own]].mean() > 0.98


def test_presses_that_judge_teach_nothing(learnt: RecordingResult) -> None:
    split, press = learnt.seen.split, learnt.seen.press
    parts = [set(press[rows].tolist()) for rows in (split.train, split.validation, split.test)]
    assert sum(map(len, parts)) == len(set().union(*parts))


def test_the_model_file_reads_images_as_in_the_training(learnt: RecordingResult, tmp_path: Path) -> None:
    write_model(tmp_path / "model.h5", learnt.model)
    model = read_model(tmp_path / "model.h5")
    seen = learnt.seen
    poses, _ = learnt.model.combine(
        learnt.model.estimate_parts(seen.moved, seen.pictures, seen.accepted), seen.accepted
    )
    for row in (3, 40, 60):
        image = next(iter(seen.recording.images.read([int(seen.rows[row])])))
        assert not isinstance(image, PalpateError)
        np.testing.assert_allclose(model.read(image)[0].pose[0], poses[row], atol=0.05)


def test_the_report_holds_every_estimator_its_errors_and_what_it_was_made_with(learnt: RecordingResult) -> None:
    data = recording_report(learnt)
    assert {"picture-ridge", "dots-ridge"} <= {one["name"] for one in data["estimators"]}
    assert data["made_by"]["palpate"]
    assert data["spec"]["seed"] == 0
    assert "331" not in page_markdown(recording_page(learnt))
    json.dumps(data)


def test_a_second_run_finds_every_stage_and_says_the_same(
    drawn: tuple[Path, DrawnTruth], learnt: RecordingResult
) -> None:
    said = Said()
    again = train_on_recording(read_recording(drawn[0]), FAST, ArtefactStore(drawn[0] / "store"), said)
    np.testing.assert_array_equal(again.estimates, learnt.estimates)
    assert not any(text.startswith("markers of") for text in said.texts)


def test_without_an_image_at_rest_the_most_central_one_is_named(copied: Path) -> None:
    (copied / "images" / "rest.png").unlink()
    seen = prepare(copied)
    assert any(re.search(r"\brest\b", note) for note in seen.notes)
    assert seen.accepted.mean() > 0.9


def test_poses_of_another_run_are_told(copied: Path) -> None:
    rng = np.random.default_rng(0)

    def other(rows: list[list[str]]) -> list[list[str]]:
        return [[row[0], *(f"{x:.3f}" for x in rng.uniform([-25, -25, 1], [25, 25, 6]))] for row in rows]

    with refused("recording-poses-unrelated"):
        learn(change_table(copied, other))


def test_shuffled_names_are_told(copied: Path) -> None:
    rng = np.random.default_rng(0)

    def shuffle(rows: list[list[str]]) -> list[list[str]]:
        return [[rows[k][0], *row[1:]] for k, row in zip(rng.permutation(len(rows)), rows, strict=True)]

    with refused("recording-poses-unrelated"):
        learn(change_table(copied, shuffle))


def test_poses_that_are_a_row_late_are_told(copied: Path) -> None:
    with refused("recording-rows-shifted", "1"):
        learn(change_table(copied, lambda rows: [[a[0], *b[1:]] for a, b in zip(rows[1:], rows, strict=False)]))


def test_copies_and_broken_or_missing_images_are_counted_and_the_others_are_used(copied: Path) -> None:
    for number in range(20):
        shutil.copy(copied / "images" / "image_00000.png", copied / "images" / f"image_{number + 30:05d}.png")
    (copied / "images" / "image_00005.png").unlink()
    (copied / "images" / "image_00006.png").write_bytes(b"\x89PNG nothing")
    found = learn(copied)
    assert len(found.seen.rows) == len(found.estimates) == COUNT - 22
    assert any(re.search(r"\b20\b", note) for note in found.seen.notes)
    assert any(re.search(r"\b2\b.*\bimage_00005\.png", note) for note in found.seen.notes)


def test_one_press_only_is_refused(copied: Path) -> None:
    def one_press(rows: list[list[str]]) -> list[list[str]]:
        return [["press", "image", "rx_deg", "ry_deg", "depth_mm"], *[["1", *row] for row in rows]]

    path = copied / "poses.csv"
    rows = list(csv.reader(path.read_text().splitlines()))[1:]
    path.write_text("\n".join(",".join(row) for row in one_press(rows)) + "\n")
    with refused("recording-few-presses", "1"):
        learn(copied)


def test_images_without_dots_are_read_from_the_picture_and_told(copied: Path) -> None:
    for number in range(0, COUNT, 2):
        path = copied / "images" / f"image_{number:05d}.png"
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        few = cv2.resize(image, (8, 6), interpolation=cv2.INTER_AREA)
        smooth = cv2.resize(few, image.shape[::-1], interpolation=cv2.INTER_CUBIC)  # so dull that no dot is left
        cv2.imwrite(str(path), smooth + np.uint8(number % 7))
    found = learn(copied)
    assert any(re.search(rf"\b{COUNT}\b", note) for note in found.seen.notes)
    assert len({score.name for score in found.scores}) >= 3
    assert 0.4 < found.seen.accepted.mean() < 0.6
    assert np.isfinite(found.estimates).all()


def test_grey_images_with_black_dots_are_named_alike(tmp_path: Path) -> None:
    draw_recording(tmp_path, draw_motions(40, 2, shear=2.0), SENSOR, threshold=False, dark=True)
    seen = prepare(tmp_path)
    assert seen.eye.dark
    assert seen.accepted.mean() > 0.95


class StoppedError(Exception):
    """A training is stopped."""


class Stopping(Progress):
    """Stops a training after three epochs."""

    def advance(self, what: str, done: float, text: str = "") -> None:
        super().advance(what, done, text)
        if "epoch 3 of" in text:
            raise StoppedError


@pytest.mark.parametrize("kind", ["markers", "images"])
def test_networks_resume_where_they_were_stopped(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs("torch")
    from palpate.learn import trainer
    from palpate.learn.train_member import ImageTask, train_marker_network

    monkeypatch.setattr(trainer, "_BETWEEN_S", -1.0)
    samples = {job.kind.reads_markers: job.samples for job in _small_jobs()}[kind == "markers"]

    def run(checkpoint: Path | None, progress: Progress | None = None) -> list[np.ndarray]:
        if kind == "markers":
            run_once = trainer.Trainer.run
            with monkeypatch.context() as patch:
                patch.setattr(trainer.Trainer, "run", lambda self, path: run_once(self, path, progress))
                return list(train_marker_network("n", samples, epochs=6, members=2, checkpoint=checkpoint).values())
        task = ImageTask("n", samples)
        [found] = trainer.Trainer(task, task.spec(6, 1), task.random).run(checkpoint, progress)
        return [np.asarray(one) for one in found.state]

    whole = run(None)
    with pytest.raises(StoppedError):
        run(tmp_path / "kept", Stopping())
    for one, other in zip(whole, run(tmp_path / "kept"), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_picture_network_in_the_file_says_what_the_trained_one_said(
    drawn: tuple[Path, DrawnTruth], tmp_path: Path
) -> None:
    needs("torch")
    needs("onnxruntime")
    found = learn(drawn[0], RecordingSpec(estimators="picture", epochs=2, picture_px=48, threads=1))
    assert "picture-network" in {score.name for score in found.scores}
    names = {part for use in (found.model.marker_ensemble, found.model.image_ensemble) if use for part in use.parts}
    assert names <= {"picture-ridge", "picture-network"}


@pytest.mark.slow
def test_pose_alone_and_all_motions_are_learnt_from_pictures_and_both_are_reported(tmp_path: Path) -> None:
    needs("torch")
    needs("onnxruntime")
    draw_gel_recording(tmp_path, draw_motions(70, 5), DrawnGel(rings=4), told=NAMES)
    found = learn(tmp_path, RecordingSpec(estimators="all", epochs=2, picture_px=48, threads=1))
    assert {"picture-network", "picture-network-all"} <= {score.name for score in found.scores}
    assert found.estimates.shape == (70, 3)


def test_places_of_markers_are_scaled_to_small_images_by_the_edges_of_pixels(learnt: RecordingResult) -> None:
    """Half a pixel lies between the edge of an image, which both sizes share, and the centre of its first pixel."""
    seen = learnt.seen
    jobs = [job for job in plan_jobs(seen, RecordingSpec(estimators="picture")) if job.name.endswith("-turned")]
    assert jobs
    assert seen.rotation is not None
    share = np.array(seen.pictures.shape[:0:-1]) / np.array(seen.eye.shape[::-1])
    for job in jobs:
        assert job.samples.rotation is not None
        assert job.samples.rotation.places_px + 0.5 == pytest.approx((seen.rotation.places_px + 0.5) * share)


def test_a_linear_estimator_of_a_simulation_is_a_start(
    drawn: tuple[Path, DrawnTruth], learnt: RecordingResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    needs("torch")
    needs("onnx")
    layout, assigned = learnt.model.layout, learnt.seen.assigned
    assert layout is not None
    assert assigned is not None
    good = learnt.seen.accepted
    samples = TrainingSet(learnt.seen.moved, learnt.seen.targets, good, good)
    part = MarkerRidge.train("ridge", samples, TrainingRun())
    rest, weight = layout.rest_px, part.arrays["weight"].astype(float)
    normal = Normalisation((210.0, 210.0), (100.0, 100.0))
    bias = part.arrays["bias"] - normal.apply(rest).reshape(-1) @ (100.0 * weight)
    estimator = Estimator(
        normal, (100.0 * weight[None],), (bias[None],), "relu", np.zeros(3), np.ones(3), rest, 0, {}, 1, 1
    )
    write_estimator(tmp_path / "simulated.onnx", estimator)
    words = ["--from", str(tmp_path / "simulated.onnx"), "--estimators", "ridge"]
    shutil.copytree(drawn[0] / "store", tmp_path / "out" / "store")  # what is not of the start is there
    with pytest.raises(SystemExit) as left:
        main(["recording", "train", str(drawn[0]), "--out", str(tmp_path / "out"), *words])
    assert left.value.code == 0
    assert "adapted-dots-network" in capsys.readouterr().out


@pytest.mark.slow
def test_a_network_of_another_unit_is_carried_over_and_adapted(tmp_path: Path) -> None:
    needs("torch")
    from palpate.learn.fine_tune import transfer_estimator

    sensor = replace(SENSOR, misprint=0.03)
    draw_recording(tmp_path / "a", draw_motions(110, 3, shear=1.0), sensor)
    draw_recording(tmp_path / "b", draw_motions(60, 4, shear=1.0), another_unit(sensor), seed=5)
    first, store = learn(tmp_path / "a"), ArtefactStore(tmp_path / "a" / "store")
    # networks are trained here: the model may hold a process alone
    jobs = [job for job in plan_jobs(first.seen, RecordingSpec(estimators="dots")) if job.name == "dots-network"]
    ((network, _),) = train_members(jobs, 1, store, Progress())
    assert first.model.layout is not None
    start = PretrainedModel("a", first.model.layout, network, first.model.space.names)
    second = learn(tmp_path / "b", FAST, start)
    assert {"adapted-dots-network", "corrected-dots-network"} <= {score.name for score in second.scores}
    alone = min(score.errors[0].rmse for score in second.scores if score.name.endswith("ridge"))
    adapted = next(score for score in second.scores if score.name == "adapted-dots-network")
    assert adapted.errors[0].rmse < alone
    assert transfer_estimator(start, second.seen).predict(second.seen.moved).shape == (60, 3)
    assert any(point.estimator == "adapted" for point in second.curve)


def test_the_command_learns_and_its_model_is_used_by_live_and_accept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = copy_learnt_sensor(tmp_path / "out")
    assert {"model.h5", "report.md", "report.json", "correspondence.png", "errors.png", "accept.md"} <= {
        path.name for path in out.iterdir()
    }
    assert "| conformity proven |" not in (out / "accept.md").read_text()  # the reference is not stated
    images, model = out / "recording" / "images", ["--model", str(out / "model.h5")]
    with pytest.raises(SystemExit) as left:
        main(["live", *model, "--source", str(images), "--count", "3", "--json"])
    assert left.value.code == 0
    readings = json.loads(capsys.readouterr().out)
    head, *rows = (out / "recording" / "poses.csv").read_text().splitlines()
    assert head.startswith("image,rx_deg,")
    assert abs(readings[1]["rx_deg"] - float(rows[1].split(",")[1])) < 12
    image, rest = head.split(",", 1)
    named = [(*row.split(",", 1), number) for number, row in enumerate(rows[:6])]
    truth = [f"{image},press,{rest}", *(f"{name},{number},{pose}" for name, pose, number in named)]
    (images / "truth.csv").write_text("\n".join(truth) + "\n")
    words = ["--rmse", "9", "--max-error", "25", "--depth-rmse", "2", "--no-zero", "--min-depth", "0"]
    with pytest.raises(SystemExit) as left:
        main(["calibration", "accept", str(images / "truth.csv"), *model, *words])
    assert left.value.code == 0


def test_a_network_on_pictures_reads_as_well_as_its_training_said(tmp_path: Path) -> None:
    """A bright dot whose place is the target: what is handed on, pooling and all, errs as the best epoch did."""
    needs("torch")
    needs("onnxruntime")
    rng = np.random.default_rng(0)
    places, rows = rng.uniform(16, 48, (300, 2)), np.arange(64)
    across, down = (np.exp(-(((rows - places[:, k, None]) / 2.5) ** 2)) for k in (0, 1))
    pictures = (255 * down[:, :, None] * across[:, None, :]).astype(np.uint8)
    lesson = TrainingSet(pictures, places, np.arange(300) < 240, np.arange(300) >= 240)
    said = Said()
    part = ImageNetwork.train("picture-network", lesson, TrainingRun(8, 1, tmp_path / "kept", said))
    least = min(float(text.split("error ")[1].split()[0]) for text in said.texts if "error" in text)
    assert lesson.error(part.predict(pictures[240:])) == pytest.approx(least, abs=2e-4)
    assert least < 0.1


@pytest.mark.parametrize(("count", "passes"), [(1460, 160), (2920, 85), (20_000, 60)])
def test_rotated_images_are_passed_over_longer_but_not_for_hours(count: int, passes: int) -> None:
    samples = TrainingSet(np.zeros((count, 1, 1)), np.zeros((count, 3)), np.ones(count, bool), np.zeros(count, bool))
    rotation = RotationAugmentation(np.zeros((1, 2)), np.zeros((1, 2)), 1)
    assert ImageNetwork.passes(replace(samples, rotation=rotation), 60) == passes
    assert ImageNetwork.passes(samples, 60) == 60


def _turned_job(sense: int = 1, aside_px: float = 0.0, auxiliary: int = 1) -> TrainingJob:
    rng, teach = np.random.default_rng(0), np.arange(60) < 45
    turning = RotationAugmentation(rng.normal(size=(9, 2)) + aside_px, np.zeros((9, 2)), sense)
    samples = TrainingSet(rng.normal(size=(60, 9, 2)), rng.normal(size=(60, 4)), teach, ~teach, 0, turning, auxiliary)
    return TrainingJob(ImageNetwork, "picture-network-turned", samples, 2)


def test_a_part_is_kept_for_the_columns_asked_for_and_the_way_that_images_turn() -> None:
    jobs = _turned_job(), _turned_job(sense=-1), _turned_job(aside_px=1.0), _turned_job(auxiliary=2)
    assert len({job.recipe.key for job in jobs}) == len(jobs)
    assert _turned_job().recipe.key == _turned_job().recipe.key


def test_a_network_on_all_motions_is_trained_anew_where_fewer_columns_are_asked_for(tmp_path: Path) -> None:
    store, job = ArtefactStore(tmp_path), _small_jobs()[1]
    jobs = [replace(job, samples=replace(job.samples, auxiliary=auxiliary)) for auxiliary in (1, 0)]
    made = [next(iter(train_members([job], 1, store, Progress())))[0] for job in jobs]
    assert [part.predict(job.samples.inputs).shape[1] for part in made] == [2, 3]


def _small_jobs(job: type[TrainingJob] = TrainingJob) -> list[TrainingJob]:
    rng = np.random.default_rng(0)
    teach = np.arange(60) < 45
    moved = TrainingSet(rng.normal(size=(60, 9, 2)), rng.normal(size=(60, 3)), teach, ~teach)
    pictures = TrainingSet(rng.integers(0, 255, (60, 32, 32)).astype(np.uint8), moved.targets, teach, ~teach)
    samples = {"dots-ridge": moved, "picture-network": pictures, "dots-network": moved}
    return [job(ESTIMATORS.get(name), name, own, 2) for name, own in samples.items()]


def test_networks_are_drawn_by_their_own_seed_and_leave_others_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever a program has drawn from torch before, and goes on to draw, is its own."""
    torch, found = pytest.importorskip("torch"), []
    from palpate.learn.train_member import train_marker_network

    monkeypatch.setitem(train_marker_network.__kwdefaults__, "epochs", 5)
    for seed in (1, 2):
        torch.manual_seed(seed)
        before = torch.get_rng_state()
        jobs = [job for job in _small_jobs() if job.cost]
        found.append([job.train(1, tmp_path / f"{seed} {job.name}", Progress()).arrays for job in jobs])
        assert torch.equal(torch.get_rng_state(), before)
    for one, other in zip(*found, strict=True):
        assert all(np.array_equal(one[key], other[key]) for key in one)


@pytest.mark.slow
def test_networks_trained_beside_each_other_are_those_trained_one_by_one(tmp_path: Path) -> None:
    needs("torch")
    said = Said()
    stores = [ArtefactStore(tmp_path / f"{threads}") for threads in (1, 2)]
    alone, beside = (
        {member.name: member for member, _ in train_members(_small_jobs(), threads, store, said)}
        for threads, store in zip((1, 2), stores, strict=True)
    )
    assert list(alone) == ["dots-ridge", "picture-network", "dots-network"]
    assert next(iter(beside)) == "dots-ridge"
    assert set(beside) == set(alone)
    for name, part in alone.items():
        for key, array in part.arrays.items():
            np.testing.assert_array_equal(array, beside[name].arrays[key])
    assert sum(bool(re.search(r"picture-network\D* 2\D+2\b", text)) for text in said.texts if "error" in text) == 2
    assert not [path for store in stores for path in store.root.rglob("*.epochs*")]


class _Dying(TrainingJob):
    def train(self, threads: int, checkpoint: Path, report: object) -> NoReturn:
        os._exit(7)


class _Refusing(TrainingJob):
    def train(self, threads: int, checkpoint: Path, report: object) -> NoReturn:
        raise PalpateError("The disk is full.", "Make room.", code="disk-full")


def test_what_a_training_process_finds_is_told_as_if_it_were_found_here(tmp_path: Path) -> None:
    needs("torch")
    with refused("disk-full") as found:
        list(train_members(_small_jobs(_Refusing)[1:], 2, ArtefactStore(tmp_path), Progress()))
    assert found.value.remedy == "Make room."


def test_a_training_process_that_dies_is_told_of(tmp_path: Path) -> None:
    needs("torch")
    with refused("training-process-died", "7"):
        list(train_members(_small_jobs(_Dying)[1:], 2, ArtefactStore(tmp_path), Progress()))
