"""From a recording to a model with honest errors: dots, correspondence, estimators, the best of them, its intervals.

Every stage lies in a store under what it was made from; a run that was interrupted goes on where it was.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import ArtefactStore, BoolArray, FloatArray, PalpateError, Recipe, provenance
from palpate.learn import ErrorSummary
from palpate.recording.assign import ASSIGN_VERSION, Assigned, assign_images, choose_reference
from palpate.recording.columns import PoseColumn
from palpate.recording.curve import CurvePoint, draw_learning_curve
from palpate.recording.layout import DotLayout
from palpate.recording.mix import choose_parts, press_quantile_of
from palpate.recording.model import Choosing, RecordedModel
from palpate.recording.part import PARTS, Part
from palpate.recording.read_recording import Recording
from palpate.recording.sight import Eye, Sight, look_at, open_eye
from palpate.recording.spec import RecordingSpec
from palpate.recording.split import PressSplit, find_doubles, find_shift, split_presses
from palpate.recording.course import CourseSpec
from palpate.recording.lesson import Lesson, fit_ridge_part
from palpate.recording.train_part import train_dots_network, train_picture_network

PART_VERSION = "1"
"""Version of the code that decides what a part predicts; part of an artefact's key."""
_NO_BETTER = 0.9
"""Error over that of the mean pose from which nothing was learnt."""
_LEAST_GOOD = 0.25
"""Least share of images with numbered dots for parts that read dots."""

Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Seen:
    """A recording as it is learnt from: unreadable and double images left out.

    Attributes
    ----------
    recording, eye, sight, assigned
        What it is, how it was looked at, what was seen, dots by number (`None` without dots).
    rows
        (n,) rows of the recording that are used.
    moved, good
        (n, m, 2) displacements and (n,) whether they are believed; empty without dots.
    pictures, targets, press
        (n, h, w), (n, k) and (n,).
    split
        What each press is for.
    notes
        What must be said about the recording.
    """

    recording: Recording
    eye: Eye
    sight: Sight
    assigned: Assigned | None
    rows: NDArray[Any]
    moved: FloatArray
    good: BoolArray
    pictures: NDArray[np.uint8]
    targets: FloatArray
    press: NDArray[Any]
    split: PressSplit
    notes: tuple[str, ...]


@dataclass(frozen=True)
class PartScore:
    """Errors of one estimator on the presses held out.

    Attributes
    ----------
    name
        Estimator.
    errors
        One summary a component, on the images that it reads.
    share
        Share of the held-out images that it reads.
    chosen_by
        Root mean square error on the validation presses, over the range's deviations: what choice goes by.
    seconds
        Time of its training; 0 where it was found in the store.
    coverage
        Share of held-out values inside its intervals, a component.
    """

    name: str
    errors: tuple[ErrorSummary, ...]
    share: float
    chosen_by: float
    seconds: float
    coverage: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Learnt:
    """What a recording gave.

    Attributes
    ----------
    seen
        What was learnt from.
    model
        The model.
    scores
        Every estimator's errors on held-out presses; `best` is that of the model as a whole.
    best
        Name of the estimator that reads images with numbered dots, or all images.
    estimates
        (n, k) of the model for all images that are used, NaN where there is none.
    curve
        Errors by number of presses.
    seconds
        Time until the first errors were known, and altogether.
    """

    seen: Seen
    model: RecordedModel
    scores: tuple[PartScore, ...]
    best: str
    estimates: FloatArray
    curve: tuple[CurvePoint, ...] = ()
    seconds: tuple[float, float] = (0.0, 0.0)
    notes: tuple[str, ...] = field(default=())


def see_recording(recording: Recording, spec: RecordingSpec, store: ArtefactStore, say: Say) -> Seen:
    """Look at a recording: dots and pictures, correspondence, split.

    Raises
    ------
    PalpateError
        If its images cannot be read, or too few are left.
    """
    eye = open_eye(recording, spec.picture_px)
    notes = list(recording.notes)
    if spec.estimators == "picture":
        eye = replace(eye, detector=None, dark=False)
    sight = look_at(recording, eye, store, say)
    count = len(recording)
    assigned = _assign(recording, eye, sight, spec, store, notes, say)
    kept = sight.readable[:count].copy()
    if not kept.all():
        first = int(np.argmin(kept))
        notes.append(
            f"{int((~kept).sum())} images cannot be read, the first is {recording.names[first]}: {sight.faults[first]}"
        )
    double, apart = find_doubles(sight.digests[:count], recording.targets)
    double &= kept
    if double.any():
        off = ", ".join(
            f"{one.axis} {apart[double, k].max():.3g} {one.unit}" for k, one in enumerate(recording.poses)
        )
        notes.append(
            f"{int(double.sum())} images are copies of others and left out; their poses differ by up to {off}."
        )
    rows = np.flatnonzero(kept & ~double)
    press = recording.press[rows]
    if len(np.unique(press)) < 8:
        raise PalpateError(
            f"{len(rows)} different images of {len(np.unique(press))} presses are left of {count}: too few to learn from.",
            " ".join(notes[-2:]),
        )
    good = np.zeros(len(rows), bool) if assigned is None else assigned.good[:count][rows]
    moved = np.zeros((len(rows), 0, 2), np.float32) if assigned is None else assigned.moved_px[:count][rows]
    split = split_presses(press, spec.held_out, spec.validation, spec.seed)
    pictures = sight.pictures[:count][rows]
    return Seen(
        recording,
        eye,
        sight,
        assigned,
        rows,
        moved,
        good,
        pictures,
        recording.targets[rows],
        press,
        split,
        tuple(notes),
    )


def _assign(
    recording: Recording,
    eye: Eye,
    sight: Sight,
    spec: RecordingSpec,
    store: ArtefactStore,
    notes: list[str],
    say: Say,
) -> Assigned | None:
    count = len(recording)
    if spec.estimators == "picture":
        return None
    without = sum(len(dots) < 6 for dots in sight.dots[:count])
    if eye.detector is None or without > 0.8 * count:
        notes.append(f"{without} of {count} images show no field of dots: learnt from pictures alone.")
        return None
    if without > 0.02 * count:
        notes.append(f"{without} of {count} images show no dots; these are read from the picture.")
    reference = choose_reference(sight, count)
    if reference < count:
        notes.append(
            f"No image is at rest; {recording.names[reference]}, the most central one, gives the layout "
            f"({len(sight.dots[reference])} dots)."
        )
    digest = hashlib.sha256(b"".join(np.ascontiguousarray(dots).tobytes() for dots in sight.dots)).hexdigest()
    recipe = Recipe("assigned", [digest, reference, spec.correspondence, list(eye.shape)], version=ASSIGN_VERSION)
    path = store.find(recipe, ".npz")
    if path is None:
        found = assign_images(sight, reference, eye.shape, spec.correspondence == "grown", say)
        own = {key: value for key, value in vars(found).items() if key not in ("layout", "reference")}
        path = store.write(recipe, lambda file: np.savez(file, rest_px=found.layout.rest_px, **own), ".npz")
    arrays = dict(np.load(path))
    assigned = Assigned(DotLayout(arrays.pop("rest_px")), reference, **arrays)
    failed = int((~assigned.good[:count]).sum())
    notes.append(
        f"{len(assigned.layout)} dots make the layout; the correspondence of {count - failed} of {count} images is believed."
    )
    if failed > (1 - _LEAST_GOOD) * count:
        notes.append("Too few to learn from dots: learnt from pictures alone.")
        return None
    return assigned


def learn_recording(
    recording: Recording, spec: RecordingSpec, store: ArtefactStore, say: Say, start: RecordedModel | None = None
) -> Learnt:
    """Learn from a recording.

    Parameters
    ----------
    recording, spec
        What is learnt from, and how.
    store
        Where stages are kept.
    say
        Told how far it is.
    start
        A model to begin with: of another unit, or of a simulation.

    Raises
    ------
    PalpateError
        If images and poses do not belong together, or too little is left to learn from.
    """
    begin = time.monotonic()
    seen = see_recording(recording, spec, store, say)
    parts: dict[str, Part] = {}
    seconds: dict[str, float] = {}
    first = 0.0
    for name in _plan(seen, spec):
        now = time.monotonic()
        parts[name] = _train(name, seen, spec, store, say)
        seconds[name] = time.monotonic() - now
        _say_errors(name, parts[name], seen, say)
        if not name.startswith("picture-network"):
            first = time.monotonic() - begin
    if start is not None:
        from palpate.recording.adapt import adapt_parts

        parts |= adapt_parts(start, seen, say)
    model, scores, best = _conclude(seen, spec, parts, seconds)
    estimates = estimate_all(model, seen)
    _refuse_strangers(seen, scores)
    curve = draw_learning_curve(seen.moved, seen.pictures, seen.good, seen.targets, seen.press, seen.split)
    return Learnt(seen, model, scores, best, estimates, curve, (first, time.monotonic() - begin))


def _plan(seen: Seen, spec: RecordingSpec) -> list[str]:
    names = [] if spec.estimators == "dots" else ["picture-ridge"]
    if seen.assigned is not None:
        names += ["dots-ridge", "dots-network"]
    if spec.estimators in ("all", "picture"):
        names += ["picture-network"]
        if seen.recording.others:
            names += ["picture-network-all"]
    return names or ["picture-ridge"]


def lesson_of(name: str, seen: Seen, spec: RecordingSpec) -> Lesson:
    """What a part learns from: dots only where they are believed, and all motions where its name says so."""
    if name.startswith("dots"):
        return Lesson(
            seen.moved, seen.targets, seen.split.teach & seen.good, seen.split.choose & seen.good, spec.seed
        )
    targets = seen.targets
    if name.endswith("-all"):
        others = np.stack([one.values for one in seen.recording.others], axis=1)[seen.rows]
        targets = np.hstack([targets, others])
    return Lesson(seen.pictures, targets, seen.split.teach, seen.split.choose, spec.seed)


def _train(name: str, seen: Seen, spec: RecordingSpec, store: ArtefactStore, say: Say) -> Part:
    lesson = lesson_of(name, seen, spec)
    digest = hashlib.sha256()
    for array in (lesson.inputs, lesson.targets, lesson.teach, lesson.judge):
        digest.update(np.ascontiguousarray(array).tobytes())
    own = [name, digest.hexdigest(), spec.seed, spec.epochs if "picture-network" in name else 0]
    recipe = Recipe("part", own, version=PART_VERSION)
    path = store.find(recipe, ".npz")
    if path is None:
        course = CourseSpec(spec.epochs, threads=spec.threads)
        kept = store.path(recipe, ".epochs")
        kept.parent.mkdir(parents=True, exist_ok=True)
        if name.endswith("-ridge"):
            part: Part = fit_ridge_part(name, lesson, name.startswith("picture"))
        elif name == "dots-network":
            part = train_dots_network(name, lesson, kept=kept)
        else:
            part = train_picture_network(name, lesson, seen.targets.shape[1], course, kept, say)
        path = store.write(recipe, lambda file: np.savez(file, **part.arrays), ".npz")
        for left in kept.parent.glob(f"{kept.stem}.*"):
            if left.suffix not in (".npz", ".json"):
                left.unlink(missing_ok=True)
    kind = "linear" if name.endswith("-ridge") else "dots-network" if name == "dots-network" else "picture-network"
    return PARTS[kind](name, dict(np.load(path)))


def _say_errors(name: str, part: Part, seen: Seen, say: Say) -> None:
    use = seen.split.judge & (seen.good if part.reads_dots else True)
    off = part.predict((seen.moved if part.reads_dots else seen.pictures)[use]) - seen.targets[use]
    errors = np.sqrt(np.mean(off**2, axis=0))
    say(f"{name}: " + ", ".join(_figure(error, one) for error, one in zip(errors, seen.recording.poses, strict=True)))


def _figure(error: float, one: PoseColumn) -> str:
    return f"{one.axis} {error:.3g}{'°' if one.unit == 'deg' else '' if one.unit == '1' else ' ' + one.unit}"


def _conclude(
    seen: Seen, spec: RecordingSpec, parts: dict[str, Part], seconds: dict[str, float]
) -> tuple[RecordedModel, tuple[PartScore, ...], str]:
    """The model, the errors of all estimators, and the name of the best."""
    count = len(seen.targets)
    estimates = {}
    for name, part in parts.items():
        readable = seen.good if part.reads_dots else np.ones(count, bool)
        estimates[name] = np.full((count, seen.targets.shape[1]), np.nan)
        estimates[name][readable] = part.predict((seen.moved if part.reads_dots else seen.pictures)[readable])
    scale = seen.targets[seen.split.teach].std(axis=0)
    options = choose_parts(
        estimates, seen.targets, seen.split.choose, scale, {n for n, p in parts.items() if p.reads_dots}
    )
    scores = []
    for option in options.ranked:
        found = option.combine(estimates)
        off = found - seen.targets
        there = np.isfinite(off).all(axis=1)
        calm = seen.split.choose & there
        width = press_quantile_of(np.abs(off[calm]), seen.press[calm], spec.level)
        judged = seen.split.judge & there
        if not judged.any():
            continue
        errors = tuple(ErrorSummary.of(off[judged, k]) for k in range(off.shape[1]))
        inside = tuple(float(x) for x in (np.abs(off[judged]) <= width).mean(axis=0))
        share = float(judged.sum() / max(seen.split.judge.sum(), 1))
        scores.append(PartScore(option.name, errors, share, option.error, seconds.get(option.name, 0.0), inside))
        option.half_width = width
    best, fallback = options.with_dots, options.without

    def choosing(option: Any) -> Choosing | None:
        return None if option is None else Choosing(option.parts, option.weights, option.half_width)

    used = {name for option in (best, fallback) if option is not None for name in option.parts}
    assigned = seen.assigned
    bank = (np.zeros(0), np.zeros(0))
    if assigned is not None:
        bank = _bank(seen)
    model = RecordedModel(
        seen.eye,
        None if assigned is None else assigned.layout,
        bank,
        {name: parts[name] for name in parts if name in used},
        choosing(best) if assigned is not None else None,
        choosing(fallback),
        tuple((one.axis, one.unit, one.column) for one in seen.recording.poses),
        _about(seen, spec),
    )
    return model, tuple(scores), (best or fallback).name


def _bank(seen: Seen) -> tuple[FloatArray, FloatArray]:
    """Displacements of images far from each other, and what they look like: guesses for other images."""
    from palpate.recording.correspond import describe_dots

    sure = np.flatnonzero(seen.good & seen.split.teach)
    features = seen.moved[sure].reshape(len(sure), -1)
    chosen = [0]
    near = np.full(len(sure), np.inf)
    for _ in range(min(199, len(sure) - 1)):
        near = np.minimum(near, ((features - features[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(near)))
    rows = sure[chosen]
    dots = [describe_dots(seen.sight.dots[seen.rows[row]], seen.eye.shape) for row in rows]
    return seen.moved[rows], np.array(dots)


def _about(seen: Seen, spec: RecordingSpec) -> dict[str, Any]:
    return {
        "recording": seen.recording.name,
        "images": len(seen.rows),
        "presses": len(np.unique(seen.press)),
        "teach": int(seen.split.teach.sum()),
        "choose": int(seen.split.choose.sum()),
        "judge": int(seen.split.judge.sum()),
        "range": [seen.targets.min(axis=0).tolist(), seen.targets.max(axis=0).tolist()],
        "spec": spec.model_dump(mode="json"),
        "made_by": provenance(),
    }


def estimate_all(model: RecordedModel, seen: Seen) -> FloatArray:
    """Estimates (n, k) of the model for all images that are used; NaN where it has none."""
    found = np.full(seen.targets.shape, np.nan)
    for use, rows in ((model.with_dots, seen.good), (model.without, ~seen.good | (model.with_dots is None))):
        if use is not None and rows.any():
            moved = seen.moved[rows] if seen.moved.shape[1] else None
            found[rows] = model.estimate(use, moved, seen.pictures[rows])
    return found


def _refuse_strangers(seen: Seen, scores: tuple[PartScore, ...]) -> None:
    """Refuse images from which poses cannot be told better than by their mean."""
    judged = seen.split.judge
    sd = np.sqrt(np.mean((seen.targets[judged] - seen.targets[seen.split.teach].mean(axis=0)) ** 2, axis=0))
    ratio = np.array([[one.rmse for one in score.errors] for score in scores]) / np.maximum(sd, 1e-12)
    best = ratio.mean(axis=1).argmin()
    features = seen.pictures[:, ::4, ::4].reshape(len(seen.pictures), -1).astype(float)
    if not (ratio[best] > _NO_BETTER).all() and ratio[best].mean() < _NO_BETTER - 0.2:
        return
    shift = find_shift(features, seen.targets, seen.split.teach)
    if shift:
        raise PalpateError(
            f"Poses and images are {abs(shift)} row{'s' if abs(shift) > 1 else ''} apart: moved by so much they fit.",
            "Mend the table.",
        )
    if (ratio[best] > _NO_BETTER).all():
        one, error = seen.recording.poses[0], scores[best].errors[0].rmse
        raise PalpateError(
            f"The poses cannot be told from the images: on presses held out the best estimate of {one.axis} is off by "
            f"{error:.3g} {one.unit}, its mean by {sd[0]:.3g} {one.unit}.",
            "Images and poses do not belong together: another run's table, or names that were shuffled.",
        )
