"""Twins of a study's designs, and how good their units will be: presses, no training."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from palpate.built import BuiltFigure, ForeseeSpec, ToleranceSpec, foresee
from palpate.camera import build_camera
from palpate.core import PalpateError
from palpate.design import MarkerSpec, SkinSpec, place_markers
from palpate.mechanics import SolverSpec
from palpate.study.observer import Observer, Silence
from palpate.study.plan import check_markers
from palpate.study.run_study import Hands, Run, writable
from palpate.study.study import Study
from palpate.study.task import PressTask, Task, TwinTask, find_made
from palpate.twin import TWIN_DERIVATIVES, read_twin

FRICTIONS: tuple[str | float, ...] = ("no-slip", 2.0, 1.2, 0.8, 0.5, 0.3, 0.2)
"""Contact laws of a twin's presses, where a study's wall is not frictionless."""
_SHARE = 0.5
"""Increments of a twin over those of the study's images."""


@dataclass(frozen=True, eq=False)
class BuiltDesign:
    """A design's twin, and what its units will be.

    Attributes
    ----------
    skin, markers
        The design.
    twin
        File of the skin's twin; `None` where it could not be made.
    figures
        Without known presses, and with some; empty without a twin.
    problem
        Why there is no twin.
    """

    skin: SkinSpec
    markers: MarkerSpec
    twin: Path | None
    figures: tuple[BuiltFigure, ...]
    problem: str = ""


def run_twins(
    study: Study,
    out: Path,
    workers: int | None = None,
    observer: Observer | None = None,
    tolerance: ToleranceSpec | None = None,
    known: int = 5,
) -> tuple[BuiltDesign, ...]:
    """Press every skin of a study under all frictions, make its twin, and foresee its units.

    What an earlier run left in ``out/store`` is used.

    Parameters
    ----------
    study, out, workers, observer
        As for `palpate.study.run_study`.
    tolerance
        How far units may be from their design.
    known
        Known presses of the second figure of each design.

    Returns
    -------
    tuple[BuiltDesign, ...]
        One a design, in the order of the study.

    Raises
    ------
    PalpateError
        If a design cannot be built, or the folder cannot be written.
    """
    allowed = tolerance or ToleranceSpec()
    twins = {skin: TwinTask(tuple(_plan_presses(study, skin))) for skin in study.designs.skins()}
    tasks: tuple[Task, ...] = tuple(task for twin in twins.values() for task in (*twin.presses, twin))
    run = Run(writable(out), tasks, Hands(workers), observer or Silence())
    run.do()
    run.do_again(tuple(twins.values()))
    run.write_failures()
    found = []
    for skin, task in twins.items():
        reason = next((run.reason(each) for each in (*task.presses, task) if run.reason(each)), "")
        path = None if reason else find_made(run.store, task)
        for markers in study.designs.markers:
            checked = check_markers(skin, markers)
            figures: tuple[BuiltFigure, ...] = ()
            problem = reason
            if path is not None:
                try:
                    figures = tuple(_foresee(study, path, checked, allowed, count) for count in (0, known))
                except PalpateError as error:
                    problem = str(error)
            found.append(BuiltDesign(skin, checked, path, figures, problem))
    return tuple(found)


def _foresee(study: Study, path: Path, markers: MarkerSpec, tolerance: ToleranceSpec, known: int) -> BuiltFigure:
    twin = read_twin(path)
    layout = place_markers(twin.skin, markers)
    spec = ForeseeSpec(known=known, max_tilt_deg=study.tilts_deg[-1], seed=study.seed)
    return foresee(twin, layout, build_camera(study.camera), tolerance, spec)


def _plan_presses(study: Study, skin: SkinSpec) -> Iterator[PressTask]:
    slippery = study.wall.contact == "frictionless"
    solver: SolverSpec = study.solver.model_copy(update={"derivatives": TWIN_DERIVATIVES})
    for contact in (study.wall.contact,) if slippery else FRICTIONS:
        for tilt_deg in study.tilts_deg:
            changed = {"tilt_deg": tilt_deg, "contact": contact, "image_step": _SHARE * study.wall.image_step}
            yield PressTask(
                skin=skin,
                mesh=study.mesh,
                material=study.material.material(),
                wall=study.wall.model_copy(update=changed),
                solver=solver,
            )
