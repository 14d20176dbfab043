"""Twins of a study's designs and the accuracy predicted from them, without training."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from palpate.calibration import PredictedAccuracy
from palpate.core.run import Progress
from palpate.design import Design
from palpate.study.accuracy_task import AccuracyTask, read_accuracy
from palpate.study.plan import plan_reading_twins, with_dependencies
from palpate.study.run_study import Run, WorkerOptions, ensure_writable
from palpate.study.study import Study
from palpate.study.task import find_artefact


@dataclass(frozen=True, eq=False)
class DesignAccuracy:
    """Twin of a design, and predicted accuracy of its units.

    Attributes
    ----------
    design
        The design.
    twin
        File of the skin's twin; `None` if it could not be made.
    accuracies
        Without and with calibration presses; empty without a twin.
    problem
        Reason for missing predictions.
    """

    design: Design
    twin: Path | None
    accuracies: tuple[PredictedAccuracy, ...]
    problem: str = ""


def run_twins(
    study: Study, out: Path, workers: int | None = None, progress: Progress | None = None
) -> tuple[DesignAccuracy, ...]:
    """Press every skin of a study at all frictions, make its twin, and predict the accuracy of units.

    Artefacts of an earlier run in ``out/store`` are reused. Parameters are those of `palpate.study.run_study`.

    Returns
    -------
    tuple[DesignAccuracy, ...]
        One a design, in the order of the study.

    Raises
    ------
    PalpateError
        If a design cannot be built, or the folder cannot be written.
    """
    built = plan_reading_twins(study)
    run = Run(ensure_writable(out), with_dependencies(built), WorkerOptions(workers), progress)
    run.run()
    run.verify_outputs((*built, *{task.twin.recipe.key: task.twin for task in built}.values()))
    run.write_failures()
    return tuple(_collect(run, task) for task in built)


def _collect(run: Run, task: AccuracyTask) -> DesignAccuracy:
    reason = next((run.reason(each) for each in (*task.twin.presses, task.twin) if run.reason(each)), "")
    twin = None if reason else find_artefact(run.store, task.twin)
    reason = reason or run.reason(task)
    figures = () if reason else read_accuracy(find_artefact(run.store, task))
    return DesignAccuracy(task.design, twin, figures, reason)
