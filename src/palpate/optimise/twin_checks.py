"""Presses that tell what the twin of a design is off: on another mesh, between its tilts and contact laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from palpate.bench import FINER
from palpate.built import KNOWN_TILTS, TwinChecks
from palpate.core import ArtefactStore
from palpate.fea import read_press
from palpate.mesh import mesh_skin
from palpate.optimise.spec import RequirementsSpec
from palpate.study import PressTask, TwinTask, find_made

_BETWEEN = (1, 3, 5)
"""Tilts that are read, each half way between two of the twin's, counted from the least."""
_STEP_SHARE = 0.8
"""Step from image to image over the twin's, so that depths lie between its own as well."""
_FRICTION = 0.25
"""Quantile of the tolerance's frictions under which is pressed; twins are furthest off under slippery walls."""


@dataclass(frozen=True)
class CheckTasks:
    """The presses of `TwinChecks`, not done yet."""

    known: tuple[PressTask, ...]
    read: tuple[PressTask, ...]

    @property
    def presses(self) -> tuple[PressTask, ...]:
        """All of them."""
        return (*self.known, *self.read)

    def find(self, store: ArtefactStore) -> TwinChecks:
        """The presses, done."""
        known, read = ([read_press(find_made(store, task)) for task in tasks] for tasks in (self.known, self.read))
        return TwinChecks(known, read)


def plan_checks(twin: TwinTask, spec: RequirementsSpec) -> CheckTasks:
    """The presses that a twin is held against."""
    tilts = sorted({press.wall.radial for press in twin.presses})
    between = [0.5 * (tilts[k - 1] + tilts[k]) for k in _BETWEEN if k < len(tilts)]
    return CheckTasks(
        known=tuple(_plan(twin, spec, [share * spec.max_tilt_deg for share in KNOWN_TILTS])),
        read=tuple(_plan(twin, spec, between)),
    )


def _plan(twin: TwinTask, spec: RequirementsSpec, tilts_deg: Sequence[float]) -> Iterator[PressTask]:
    own = twin.presses[0]
    coarse = mesh_skin(own.skin.build(), own.mesh).spec
    mesh = coarse.model_copy(update={"cells": round(FINER * (coarse.cells or 0))})
    contact = spec.tolerance.draw_friction(_FRICTION) if spec.tolerance.friction else own.wall.contact
    for tilt_deg in tilts_deg:
        wall = own.wall.model_copy(
            update={
                "tilt_deg": round(tilt_deg, 6),
                "contact": contact,
                "image_step": _STEP_SHARE * own.wall.image_step,
            }
        )
        plain = own.solver.model_copy(update={"derivatives": ()})
        yield replace(own, mesh=mesh, wall=wall, solver=plain)
