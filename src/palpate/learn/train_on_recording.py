"""Training on a recording: markers, correspondence, estimators, selection, intervals.

The result of every stage is in a store under its recipe, so that an interrupted run resumes.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from palpate.core import ArtefactStore, FloatArray, PalpateError
from palpate.core.run import Progress
from palpate.datasets import PoseColumn, PressSplit, Recording
from palpate.learn.cross_validate import count_folds, cross_validate, predict_parts
from palpate.learn.fine_tune import PretrainedModel, compute_fine_tuning_curve, fine_tune_members
from palpate.learn.gaussian_process import MOST_ROWS
from palpate.learn.learning_curve import CurvePoint, compute_learning_curve, train_quickly
from palpate.learn.member import EFFORTS, ESTIMATORS, EnsembleMember
from palpate.learn.prepare_recording import PreparedRecording, prepare_recording
from palpate.learn.recording_model import RecordedModel
from palpate.learn.recording_spec import RecordingSpec
from palpate.learn.rotation import pattern_order
from palpate.learn.row_offset import find_row_offset
from palpate.learn.select_model import WHOLE, EstimatorScore, select_model
from palpate.learn.simulated_start import SimulatedStart
from palpate.learn.train_members import TrainingJob, train_members

_LEAST_SAMPLES = 4
"""Minimum number of training images of an estimator. By hand."""
_NO_BETTER, _DOUBTFUL = 0.9, 0.7
"""Error ratio to the mean pose: limits of a failed training, of a search for a row offset. By hand."""


@dataclass(frozen=True, eq=False)
class RecordingResult:
    """Result of a training on a recording.

    Attributes
    ----------
    seen
        The prepared recording.
    model
        The model.
    scores
        Errors of every estimator on held-out presses; `best` is that of the model as a whole.
    best
        Name of the estimator that reads images with assigned markers, or all images.
    estimates
        (n, k) of the model for all images that are used, NaN if missing.
    curve
        Errors by number of presses.
    seconds
        Time until the first errors were known, and in total.
    """

    seen: PreparedRecording
    model: RecordedModel
    scores: tuple[EstimatorScore, ...]
    best: str
    estimates: FloatArray
    curve: tuple[CurvePoint, ...] = ()
    seconds: tuple[float, float] = (0.0, 0.0)


def train_on_recording(
    recording: Recording,
    spec: RecordingSpec,
    store: ArtefactStore,
    progress: Progress,
    start: PretrainedModel | SimulatedStart | None = None,
    first: RecordingResult | None = None,
) -> RecordingResult:
    """Train estimators on a recording.

    Parameters
    ----------
    recording, spec
        The recording, and the settings.
    store
        Store of the stages.
    progress
        Receives the images and trainings done.
    start
        Pretrained model of another unit, or the simulation of the design.
    first
        Result of fewer estimators for the same recording: its learning curve and times are reused.

    Raises
    ------
    PalpateError
        If images and poses do not belong together, or too few images remain.
    """
    begin = time.monotonic()
    seen = prepare_recording(recording, spec, store, progress)
    seconds = {} if first is None else {score.name: score.seconds for score in first.scores}
    known, early = set(seconds), 0.0 if first is None else first.seconds[0]
    few = count_folds(seen, spec) > 0

    def train(own: PreparedRecording) -> dict[str, EnsembleMember]:
        nonlocal early
        jobs, parts = list(plan_jobs(own, spec, few)), {}
        for part, spent in train_members(jobs, spec.threads, store, Progress() if few else progress):
            name, parts[part.name] = part.name, part
            seconds[name] = max(seconds.get(name, 0.0), spent)
            if name not in known and not few:
                _report_errors(name, parts[name], own, progress)
            if first is None and part.effort != "all":
                early = time.monotonic() - begin
        parts = {job.name: parts[job.name] for job in jobs}
        return parts if start is None else parts | fine_tune_members(start, own, Progress() if few else progress, few)

    every = np.ones(len(seen.targets), bool)
    if few:
        parts, held_out = cross_validate(seen, spec, train, progress)
        scored = replace(seen, split=PressSplit(every, every, every))
    else:
        parts, scored = train(seen), seen
        held_out = predict_parts(seen, parts, every)
    model, scores, best = select_model(scored, spec, parts, held_out, seconds)
    _refuse_strangers(scored, scores)
    if start is not None and set(model.parts) <= {job.name for job in plan_jobs(seen, spec, few)}:
        note = f"{start.name} is not a suitable start: estimators without it have smaller errors, and are used."
        scored = replace(scored, notes=(*scored.notes, note))
    if not few and len(np.unique(seen.press)) <= MOST_ROWS:
        # estimators without choices on validation presses are trained on all presses, after their errors are known
        whole_set = replace(seen, split=PressSplit(every, ~every, ~every))
        jobs = [one for one in plan_jobs(whole_set, spec) if one.name in model.parts and not one.kind.uses_validation]
        again = {part.name: part for part, _ in train_members(jobs, spec.threads, store, progress)}
        if isinstance(start, SimulatedStart):
            again |= fine_tune_members(start, whole_set, Progress())
        again = {name: part for name, part in again.items() if name in model.parts}
        model = replace(model, parts={**model.parts, **again})
    if first is None:
        samples, test = seen.samples(markers=bool(seen.accepted.sum() > 0.5 * len(seen.accepted)))
        rotation = seen.rotation if samples.inputs.dtype != np.uint8 else None
        enough = samples.train.sum() >= _LEAST_SAMPLES and test.any() and samples.validation.any()
        lesson = replace(samples, rotation=rotation)
        curve = compute_learning_curve(lesson, seen.press, test, train_quickly) if enough else ()
        curve += compute_fine_tuning_curve(start, seen) if start is not None else ()
    else:
        curve = first.curve
    estimates, _ = model.combine(held_out, seen.accepted)
    whole = time.monotonic() - begin + (0.0 if first is None else first.seconds[1])
    return RecordingResult(scored, model, scores, best, estimates, curve, (early, whole))


def plan_jobs(seen: PreparedRecording, spec: RecordingSpec, few: bool = False) -> Iterator[TrainingJob]:
    """Kinds of estimators that recording and spec allow: plain, with rotations, with all motions.

    Few presses train closed forms only, and also those that are for validation, if a kind makes no choices on them.
    """
    chosen, rotation = spec.estimators, seen.rotation
    if chosen == "dots" and seen.assigned is None:
        chosen = "ridge"
    efforts = EFFORTS[: EFFORTS.index(chosen) + 1 if chosen in EFFORTS else None]
    reads = {"dots": (True,), "picture": (False,)}.get(chosen, (True, False))
    for kind_name, kind in ESTIMATORS.available():
        reads_markers = kind.reads_markers
        if kind.effort not in efforts or reads_markers not in reads or (reads_markers and seen.assigned is None):
            continue
        samples, _ = seen.samples(reads_markers, spec.seed)
        if (few and kind.cost(samples, spec.epochs)) or samples.train.sum() < _LEAST_SAMPLES:
            continue
        if few and not kind.uses_validation:
            samples = replace(samples, train=samples.train | samples.validation)
        if kind.suits(samples):
            yield TrainingJob(kind, kind_name, samples, spec.epochs)
        if kind.takes_rotation and rotation is not None:
            places = rotation.places_px
            if not reads_markers:  # in px of the small images
                scale = np.array(seen.pictures.shape[:0:-1]) / seen.eye.shape[::-1]
                places = (places + 0.5) * scale - 0.5
            if reads_markers or pattern_order(rotation.places_px) > 1:
                turned = replace(samples, rotation=rotation._replace(places_px=places))
                if kind.suits(turned):
                    yield TrainingJob(kind, f"{kind_name}-turned", turned, spec.epochs)
        if kind.takes_auxiliary and seen.recording.others:
            others = np.stack([one.values for one in seen.recording.others], axis=1)[seen.rows]
            whole = replace(samples, targets=np.hstack([samples.targets, others]), auxiliary=others.shape[1])
            yield TrainingJob(kind, f"{kind_name}-all", whole, spec.epochs)


def _report_errors(name: str, part: EnsembleMember, seen: PreparedRecording, progress: Progress) -> None:
    samples, use = seen.samples(part.reads_markers)
    off = part.predict(samples.inputs[use]) - seen.targets[use]
    errors = np.sqrt(np.mean(off**2, axis=0))
    progress.note(
        f"{name}: " + ", ".join(_figure(error, one) for error, one in zip(errors, seen.recording.poses, strict=True))
    )


def _figure(error: float, one: PoseColumn) -> str:
    return f"{one.axis} {error:.3g}{'°' if one.unit == 'deg' else '' if one.unit == '1' else ' ' + one.unit}"


def _refuse_strangers(seen: PreparedRecording, scores: tuple[EstimatorScore, ...]) -> None:
    """Reject images from which poses are estimated no better than by their mean."""
    scored = seen.split.test
    sd = np.sqrt(np.mean((seen.targets[scored] - seen.targets[seen.split.train].mean(axis=0)) ** 2, axis=0))
    ratio = np.array([[one.rmse for one in score.errors] for score in scores if score.name != WHOLE])
    ratio = ratio / np.maximum(sd, 1e-12)
    best = ratio.mean(axis=1).argmin()
    features = seen.pictures[:, ::4, ::4].reshape(len(seen.pictures), -1).astype(float)
    if not (ratio[best] > _NO_BETTER).all() and ratio[best].mean() < _DOUBTFUL:
        return
    shift = find_row_offset(features, seen.targets, seen.split.train)
    if shift:
        raise PalpateError(
            f"Poses and images are {abs(shift)} row{'s' if abs(shift) > 1 else ''} apart: moved by so much they fit.",
            "Correct the table.",
            code="recording-rows-shifted",
        )
    if (ratio[best] > _NO_BETTER).all():
        one, error = seen.recording.poses[0], scores[best].errors[0].rmse
        raise PalpateError(
            f"The images do not determine the poses: on held-out presses the RMSE of {one.axis} is "
            f"{error:.3g} {one.unit}; the mean pose gives {sd[0]:.3g} {one.unit}.",
            "Images and poses do not belong together: another run's table, or names that were shuffled.",
            code="recording-poses-unrelated",
        )
