"""Validation presses of a twin: on another mesh, between its tilts and contact laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from palpate.calibration import CALIBRATION_TILTS, ValidationPresses
from palpate.core import ArtefactStore
from palpate.fea import read_press
from palpate.mesh import mesh_skin
from palpate.optimise.spec import RequirementsSpec
from palpate.simulation import FINER
from palpate.study import PressTask, TwinTask, find_artefact

_READ = ((1, 0.7887), (4, 0.2113), (6, 0.2113))
"""Tilts that are evaluated: index of a gap between two of the twin's tilts, and share of it.

They are near the nodes of the three-point Gauss rule over all tilts, and at nodes of the two-point rule in their
gaps: at mid-gap the error of the twin is largest.
"""
_STEP_SHARE = 0.8
"""Depth step over the twin's, so that depths between its increments are covered. By hand."""
_FRICTIONS = (0.2113, 0.7887)
"""Quantiles of the tolerance's frictions: nodes of the two-point Gauss rule.

The error of some twins is larger at low friction, that of others at high friction.
"""


@dataclass(frozen=True)
class ValidationPressTasks:
    """Tasks of `ValidationPresses`."""

    known: tuple[PressTask, ...]
    read: tuple[PressTask, ...]

    @property
    def presses(self) -> tuple[PressTask, ...]:
        """All presses."""
        return (*self.known, *self.read)

    def find(self, store: ArtefactStore) -> ValidationPresses:
        """Return the solved presses from the store."""
        known, read = (
            [read_press(find_artefact(store, task)) for task in tasks] for tasks in (self.known, self.read)
        )
        return ValidationPresses(known, read)


def plan_validation_presses(twin: TwinTask, spec: RequirementsSpec) -> tuple[ValidationPressTasks, ...]:
    """Plan the presses that measure the error of a twin, one `ValidationPressTasks` per friction."""
    tilts = sorted({press.obstacle.radial for press in twin.presses})
    known = [share * spec.max_tilt_deg for share in CALIBRATION_TILTS]
    between = [tilts[k - 1] + share * (tilts[k] - tilts[k - 1]) for k, share in _READ if k < len(tilts)]
    tolerance, own = spec.tolerance, twin.presses[0].obstacle.contact
    contacts = [round(tolerance.friction_at(share), 3) for share in _FRICTIONS] if tolerance.friction_min else [own]
    return tuple(
        ValidationPressTasks(tuple(_plan(twin, known, each)), tuple(_plan(twin, between, each))) for each in contacts
    )


def _plan(twin: TwinTask, tilts_deg: Sequence[float], contact: str | float) -> Iterator[PressTask]:
    own = twin.presses[0]
    coarse = mesh_skin(own.design.skin, own.mesh).spec
    mesh = coarse.model_copy(update={"cells": round(FINER * (coarse.cells or 0))})
    for tilt_deg in tilts_deg:
        changed = {
            "tilt_deg": round(tilt_deg, 3),
            "contact": contact,
            "depth_step": _STEP_SHARE * own.obstacle.depth_step,
        }
        plain = own.solver.model_copy(update={"derivatives": ()})
        yield replace(own, mesh=mesh, obstacle=own.obstacle.model_copy(update=changed), solver=plain)
