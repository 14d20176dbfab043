"""Report of a training on a recording: page, data, and figures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.core import PalpateError, wrap_write_errors
from palpate.core.report import Report
from palpate.datasets import Recording
from palpate.learn.learning_curve import extrapolate_learning_curve
from palpate.learn.select_model import EstimatorScore
from palpate.learn.train_on_recording import RecordingResult

_SHOWN, _DPI, _DIM = 6, 110, 0.6
"""Number of images shown, resolution, and brightness of images under the marker displacements."""


def recording_report(result: RecordingResult) -> dict[str, Any]:
    """Return the results of a training as plain data."""
    seen, outputs = result.seen, result.model.outputs
    assigned = seen.assigned
    return {
        **result.model.about,
        "outputs": [{"axis": axis, "unit": unit, "column": column} for axis, unit, column in outputs],
        "notes": list(seen.notes),
        "best": result.best,
        "dots": None if assigned is None else len(assigned.layout),
        "correspondence": None if assigned is None else {key or "believed": n for key, n in assigned.counts.items()},
        "estimators": [
            {
                "name": score.name,
                "share_of_images": score.share,
                "validation_error": score.validation_error,
                "seconds": score.seconds,
                "errors": {
                    axis: {**vars(error), "coverage": inside}
                    for (axis, _, _), error, inside in zip(outputs, score.errors, score.coverage, strict=True)
                },
            }
            for score in result.scores
        ],
        "curve": [vars(point) for point in result.curve],
        "enough": extrapolate_learning_curve(result.curve),
        "seconds": {"first_errors": result.seconds[0], "all": result.seconds[1]},
    }


def recording_page(result: RecordingResult) -> list[str | Report]:
    """Yield paragraphs and tables of the report."""
    seen, outputs, about = result.seen, result.model.outputs, result.model.about
    names = [f"{axis} {'' if unit == '1' else unit}".strip() for axis, unit, _ in outputs]
    head = (
        "estimator",
        "images read",
        *(f"{name} RMSE" for name in names),
        *(f"{name} max" for name in names),
        "in interval",
    )
    best = next(score for score in result.scores if score.name == result.best)
    held = len(np.unique(seen.press[seen.split.test]))
    rows = [_row(score, score.name == result.best, bool(about["folds"])) for score in result.scores]
    figures = ", ".join(f"{name} {error.rmse:.3g}" for name, error in zip(names, best.errors, strict=True))
    return [
        f"# Results of the recording {seen.recording.name}",
        f"**{result.best}: {figures}** RMSE on {held} presses that did not train it.",
        *_describe_sets(about),
        Report.of("", head, rows, details=[f"{name} max" for name in names]),
        "## Notes on the recording",
        "\n".join(f"* {note}" for note in seen.notes),
        "## Learning curve",
        Report.of(
            "",
            ("presses", "estimator", *(f"{name} RMSE" for name in names)),
            [(str(p.presses), p.estimator, *(f"{x:.3g}" for x in p.rmse)) for p in result.curve],
        ),
        extrapolate_learning_curve(result.curve),
        "" if seen.assigned is None else "![assigned markers](correspondence.png)",
        "![errors](errors.png)",
        f"First errors after {result.seconds[0]:.0f} s, all after {result.seconds[1]:.0f} s. Made by "
        + ", ".join(f"{name} {version}" for name, version in about["made_by"].items())
        + f"; seed {about['spec']['seed']}.",
    ]


def _describe_sets(about: Mapping[str, Any]) -> tuple[str, str]:
    """Sets of images for training, selection and test: their numbers, and their use."""
    images, level = f"{about['images']} images of {about['presses']} presses", f"{about['spec']['level']:.0%}"
    if about["folds"]:
        return (
            f"{images}, cross-validated in {about['folds']} folds.",
            "Each press is estimated by models trained on others. These errors choose the estimator and give the "
            f"intervals of {level}. The saved model is trained on all presses, but for those by which ridge "
            "regression and fine-tuned estimators choose.",
        )
    return (
        f"{images}: {about['train']} training images, {about['validation']} for validation and for the intervals of "
        f"{level}, {about['test']} test images.",
        "No press is in two of these sets. The estimator was selected by the validation presses; the table shows the "
        "test presses. Of up to 1000 presses all train the Gaussian processes of the saved model.",
    )


def draw_recording_report(folder: Path, result: RecordingResult) -> None:
    """Draw ``correspondence.png`` and ``errors.png`` into a folder.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    with wrap_write_errors(folder, "Choose another folder."):
        _draw_errors(result).savefig(folder / "errors.png", dpi=_DPI)
        if result.seen.assigned is not None:
            _draw_correspondences(result, result.seen.recording).savefig(folder / "correspondence.png", dpi=_DPI)


def _draw_errors(result: RecordingResult) -> Figure:
    seen, outputs = result.seen, result.model.outputs
    count = len(outputs)
    figure = Figure(figsize=(3.3 * count + 3.3, 3.2), layout="constrained")
    axes = figure.subplots(1, count + 1, squeeze=False)[0]
    off = result.estimates - seen.targets
    for column, (axis, (name, unit, _)) in enumerate(zip(axes, outputs, strict=False)):
        for rows, colour, what in ((seen.accepted, "C0", "by markers"), (~seen.accepted, "C1", "by image")):
            shown = rows & seen.split.test
            if shown.any():
                axis.plot(
                    seen.targets[shown, column], off[shown, column], ".", color=colour, markersize=4, label=what
                )
        axis.axhline(0, color="0.6", linewidth=0.8)
        label = name if unit == "1" else f"{name} ({unit})"
        axis.set_xlabel(label)
        axis.set_ylabel(f"error of {label}")
        _bare(axis)
    axes[0].legend(fontsize=7, frameon=False)
    presses = [point.presses for point in result.curve]
    for column, (name, unit, _) in enumerate(outputs):
        values = [point.rmse[column] for point in result.curve]
        axes[-1].loglog(presses, values, "o-", label=f"{name} ({unit})", markersize=4)
    axes[-1].set_xticks(presses, [str(count) for count in presses])
    axes[-1].minorticks_off()
    axes[-1].set_xlabel("training presses")
    axes[-1].set_ylabel("RMSE on held-out presses")
    axes[-1].legend(fontsize=7, frameon=False)
    _bare(axes[-1])
    return figure


def _draw_correspondences(result: RecordingResult, recording: Recording) -> Figure:
    """Images by ascending motion, and some failed ones, with the displacement of each marker."""
    seen = result.seen
    assert seen.assigned is not None
    far = np.linalg.norm(seen.moved, axis=-1).mean(axis=1)
    good = np.flatnonzero(seen.accepted)
    bad = np.flatnonzero(~seen.accepted)[: _SHOWN // 3]
    good = good[np.argsort(far[good])]
    shown = [*good[np.linspace(0, len(good) - 1, _SHOWN - len(bad)).astype(int)].tolist(), *bad.tolist()]
    figure = Figure(figsize=(9, 6.4), layout="constrained")
    rest = seen.assigned.layout.rest_px
    for axis, row in zip(figure.subplots(2, _SHOWN // 2).ravel(), shown, strict=True):
        number = int(seen.rows[row])
        item = next(iter(recording.images.read([number])))
        if not isinstance(item, PalpateError):
            picture = item if item.ndim == 2 else item[..., ::-1]
            axis.imshow(picture / max(float(item.max()), 1.0) * _DIM, cmap="gray", vmin=0, vmax=1)
        found = seen.assigned.found[number]
        moved = seen.moved[row]
        reason = str(seen.assigned.faults[number])
        if not reason:
            axis.quiver(
                *rest[found].T, *moved[found].T, angles="xy", scale_units="xy", scale=1, color="C1", width=0.004
            )
            axis.plot(*(rest + moved)[~found].T, "x", color="C3", markersize=4)
        axis.set_title(f"{recording.names[number]}\n{reason or f'{found.sum()} of {len(rest)} markers'}", fontsize=7)
        axis.set_axis_off()
    return figure


def _bare(axis: Axes) -> None:
    axis.spines[["top", "right"]].set_visible(False)


def _row(score: EstimatorScore, best: bool, folds: bool) -> tuple[str, ...]:
    """Cells of an estimator, without coverage if the same errors gave the intervals."""
    rmse, most = [f"{one.rmse:.3g}" for one in score.errors], [f"{one.max:.3g}" for one in score.errors]
    name = f"{score.name} (chosen)" if best else score.name
    return (
        name,
        f"{score.share:.0%}",
        *rmse,
        *most,
        "–" if folds else " / ".join(f"{inside:.0%}" for inside in score.coverage),
    )
