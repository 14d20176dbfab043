"""Recordings of few presses: cross-validation, and models of eight to twenty presses."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drawn_tactip import DrawnSensor, draw_motions, draw_recording
from palpate.core import ArtefactStore
from palpate.core.run import Progress
from palpate.datasets import Recording, read_recording
from palpate.learn import RecordingSpec, prepare_recording, train_on_recording
from palpate.learn.cross_validate import count_folds, cross_validate, predict_parts
from palpate.learn.member import ImageRidge, TrainingRun

SPEC = RecordingSpec(estimators="ridge", threads=1)


@pytest.fixture(autouse=True)
def small_images(monkeypatch: pytest.MonkeyPatch) -> None:
    """Images of 16 px, and few draws: the choices of size and kernel are tested elsewhere, and take time a fold."""
    monkeypatch.setattr(ImageRidge, "sides", (16,))
    for module in ("gaussian_process", "motion_model"):
        monkeypatch.setattr(f"palpate.learn.{module}.MOST_TUNED", 60)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("few")
    draw_recording(place, draw_motions(30, 3, shear=1.0, tilt=15.0), DrawnSensor(rings=5))
    return place


def first(folder: Path, count: int, name: str) -> Recording:
    rows = (folder / "poses.csv").read_text().splitlines()
    (folder / name).write_text("\n".join(rows[: count + 1]) + "\n")
    return read_recording(folder / name)


@pytest.mark.parametrize("count", [8, 9, 10])
def test_so_few_presses_give_a_model_with_every_press_judged(folder: Path, count: int) -> None:
    learnt = train_on_recording(
        first(folder, count, f"{count}.csv"), SPEC, ArtefactStore(folder / f"store{count}"), Progress()
    )
    assert learnt.model.about["folds"] == count
    assert np.isfinite(learnt.estimates).all()
    assert all(score.share > 0.7 for score in learnt.scores)
    assert np.isfinite(learnt.model.image_ensemble.half_width).all() == (count >= 9)
    spread = learnt.seen.targets.std(axis=0)
    assert min(score.errors[0].rmse for score in learnt.scores) < 0.8 * spread[0]


def test_no_press_is_estimated_by_a_model_that_it_trained(folder: Path) -> None:
    seen = prepare_recording(first(folder, 24, "24.csv"), SPEC, ArtefactStore(folder / "store24"), Progress())
    trained = []

    def train(own):
        trained.append(own.split)
        samples, _ = own.samples(markers=False)
        return {"ridge": ImageRidge.train("ridge", samples, TrainingRun())}

    parts, held_out = cross_validate(seen, SPEC, train, Progress())
    assert not any((split.train & split.test).any() or (split.validation & split.test).any() for split in trained)
    assert np.all(np.sum([split.test for split in trained], axis=0) == 1)
    own = predict_parts(seen, parts, np.ones(24, bool))["ridge"]
    left, fitted = (np.sqrt(np.mean((found - seen.targets) ** 2)) for found in (held_out["ridge"], own))
    assert fitted < 0.8 * left


def test_a_press_without_assigned_markers_is_left_to_the_image(folder: Path) -> None:
    seen = prepare_recording(first(folder, 10, "10.csv"), SPEC, ArtefactStore(folder / "store10"), Progress())
    accepted = seen.accepted.copy()
    accepted[3] = False
    seen = replace(seen, accepted=accepted)
    from palpate.learn.train_members import train_members
    from palpate.learn.train_on_recording import plan_jobs

    def train(own):
        jobs = list(plan_jobs(own, SPEC, few=True))
        return {part.name: part for part, _ in train_members(jobs, 1, ArtefactStore(folder / "store10"), Progress())}

    _, held_out = cross_validate(seen, SPEC, train, Progress())
    assert np.isnan(held_out["dots-process"][3]).all()
    assert np.isfinite(held_out["picture-ridge"]).all()
    assert np.isfinite(np.delete(held_out["dots-process"], 3, axis=0)).all()


def test_the_share_done_grows_with_each_fold(folder: Path) -> None:
    shares: list[float] = []

    class Kept(Progress):
        def finish(self, what: str, reason: str = "") -> None:
            super().finish(what, reason)
            shares.append(self.share)

    seen = prepare_recording(first(folder, 24, "24.csv"), SPEC, ArtefactStore(folder / "store24"), Progress())
    cross_validate(seen, SPEC, lambda own: {}, Kept())
    folds = count_folds(seen, SPEC)
    assert shares == pytest.approx([(k + 1) / (folds + 1) for k in range(folds + 1)])
