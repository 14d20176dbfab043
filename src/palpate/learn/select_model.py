"""Selection of a model from trained estimators: errors, best estimator, intervals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from palpate.core import FloatArray, provenance
from palpate.learn.cross_validate import count_folds
from palpate.learn.ensemble import Ensemble, select_ensemble
from palpate.learn.error_scale import fit_scale
from palpate.learn.member import EnsembleMember
from palpate.learn.metrics import ErrorSummary
from palpate.learn.prepare_recording import PreparedRecording
from palpate.learn.recording_model import BANK, RecordedModel
from palpate.learn.recording_spec import RecordingSpec
from palpate.vision import marker_descriptor

WHOLE = "all images, by dots or by picture"
"""Name of the model as a whole, if some images are read by markers and some by an image estimator."""
_APART, _WORTH, _LEAST_APART = (1.0, 1.5, 2.0, 3.0), 0.95, 20
"""Selection of the maximum disagreement of marker and image ensembles.

Multiples of the 90 % quantile that are tried; maximum ratio of the square error for a limit; minimum number of
images. By hand.
"""


@dataclass(frozen=True)
class EstimatorScore:
    """Errors of one estimator on the presses held out.

    Attributes
    ----------
    name
        Estimator.
    errors
        One summary a component, on the images that it reads.
    share
        Share of the held-out images that it reads.
    validation_error
        RMSE on the validation presses, over the standard deviations of the targets: the criterion of selection.
    seconds
        Time of its training; 0 if it was in the store.
    coverage
        Share of held-out values inside its intervals, a component.
    """

    name: str
    errors: tuple[ErrorSummary, ...]
    share: float
    validation_error: float
    seconds: float
    coverage: tuple[float, ...]


def select_model(
    seen: PreparedRecording,
    spec: RecordingSpec,
    parts: dict[str, EnsembleMember],
    estimates: Mapping[str, FloatArray],
    seconds: dict[str, float],
) -> tuple[RecordedModel, tuple[EstimatorScore, ...], str]:
    """Select the model; return it with the errors of all estimators and the name of the best.

    Parameters
    ----------
    seen, spec, parts
        The recording, the settings, and the trained estimators by name.
    estimates
        Estimates (n, k) of each; those of validation and test presses decide and are reported.
    seconds
        Training time of each.
    """
    scale = seen.targets[seen.split.train].std(axis=0)
    ranked, best, fallback = select_ensemble(
        estimates, seen.targets, seen.split.validation, scale, {n for n, p in parts.items() if p.reads_markers}
    )
    used = {name for option in (best, fallback) if option is not None for name in option.parts}
    assigned = seen.assigned
    bank = (np.zeros(0),) * 4 if assigned is None else (*_bank(seen), assigned.motion, assigned.usual)
    model = RecordedModel(
        seen.eye,
        None if assigned is None else assigned.layout,
        bank,
        parts,
        best if assigned is not None else None,
        fallback,
        _apart(best, fallback, estimates, seen),
        tuple((one.axis, one.unit, one.column) for one in seen.recording.poses),
        _about(seen, spec),
    )
    scores, every = [], np.full(seen.targets.shape, np.inf)
    missing = np.zeros(len(seen.targets), int) if assigned is None else (~assigned.found[seen.rows]).sum(axis=1)
    for option in ranked:
        poses = option.combine(estimates)
        calm = seen.split.validation & np.isfinite(poses).all(axis=1)
        features = model.features(option, estimates, seen.moved, missing)
        errors = (poses - seen.targets)[calm]
        option.half_width, option.scale = fit_scale(features[calm], errors, seen.press[calm], spec.level)
        widths = option.half_widths(features)
        every = widths if option is fallback else every
        score = _score(option, poses, widths, seen, seconds)
        scores += [score] if score is not None else []
    found, by_dots = model.combine(estimates, seen.accepted)
    if assigned is not None and not by_dots[seen.split.test].all():
        whole = Ensemble((), np.zeros(0), name=WHOLE)
        if best is not None:
            own = best.half_widths(model.features(best, estimates, seen.moved, missing))
            every = np.where(by_dots[:, None], own, every)
        score = _score(whole, found, every, seen, {})
        scores += [score] if score is not None else []
    model = replace(model, parts={name: parts[name] for name in parts if name in used})
    return model, tuple(scores), (best or fallback or ranked[0]).name


def _apart(
    best: Ensemble | None,
    fallback: Ensemble | None,
    estimates: Mapping[str, FloatArray],
    seen: PreparedRecording,
) -> FloatArray:
    """Maximum disagreement (k,) of marker and image ensembles, by minimum validation error."""
    never = np.full(seen.targets.shape[1], np.inf)
    if best is None or fallback is None or best is fallback:
        return never
    by_dots, by_picture = best.combine(estimates), fallback.combine(estimates)
    rows = seen.split.validation & seen.accepted & np.isfinite(by_dots).all(axis=1)
    if rows.sum() < _LEAST_APART:
        return never
    usual = np.quantile(np.abs(by_dots - by_picture)[rows], 0.9, axis=0)
    scale = np.maximum(seen.targets[seen.split.train].std(axis=0), 1e-12)

    def error(limit: FloatArray) -> float:
        left = (np.abs(by_dots - by_picture) > limit).any(axis=1, keepdims=True)
        return float(np.mean((((np.where(left, by_picture, by_dots) - seen.targets) / scale)[rows]) ** 2))

    tries = [never, *(factor * usual for factor in _APART)]
    errors = [error(limit) for limit in tries]
    return tries[int(np.argmin(errors))] if min(errors) < _WORTH * errors[0] else never


def _score(
    option: Ensemble,
    found: FloatArray,
    width: FloatArray,
    seen: PreparedRecording,
    seconds: dict[str, float],
) -> EstimatorScore | None:
    """Errors of estimates (n, k) on the held-out presses; `None` without such estimates."""
    off = found - seen.targets
    scored = seen.split.test & np.isfinite(off).all(axis=1)
    if not scored.any():
        return None
    errors = tuple(ErrorSummary.of(off[scored, k]) for k in range(off.shape[1]))
    inside = np.abs(off[scored]) <= width[scored]
    share = float(scored.sum() / max(seen.split.test.sum(), 1))
    coverage = tuple(float(x) for x in inside.mean(axis=0))
    return EstimatorScore(option.name, errors, share, option.error, seconds.get(option.name, 0.0), coverage)


def _bank(seen: PreparedRecording) -> tuple[FloatArray, FloatArray]:
    """Displacements of images far from each other, with their descriptors: initial guesses of assignments."""
    sure = np.flatnonzero(seen.accepted & seen.split.train)
    features = seen.moved[sure].reshape(len(sure), -1)
    chosen = [0]
    near = np.full(len(sure), np.inf)
    for _ in range(min(BANK - 1, len(sure) - 1)):
        near = np.minimum(near, ((features - features[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(near)))
    rows = sure[chosen]
    dots = [marker_descriptor(seen.sight.blobs[seen.rows[row]], seen.eye.shape) for row in rows]
    return seen.moved[rows], np.array(dots)


def _about(seen: PreparedRecording, spec: RecordingSpec) -> dict[str, Any]:
    return {
        "recording": seen.recording.name,
        "images": len(seen.rows),
        "presses": len(np.unique(seen.press)),
        "train": int(seen.split.train.sum()),
        "validation": int(seen.split.validation.sum()),
        "test": int(seen.split.test.sum()),
        "folds": count_folds(seen, spec),
        "range": [seen.targets.min(axis=0).tolist(), seen.targets.max(axis=0).tolist()],
        "spec": spec.model_dump(mode="json"),
        "made_by": provenance(),
    }
