"""Tasks of the predicted accuracy of built units: twin of a skin, and prediction for a design."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import ceil
from pathlib import Path
from typing import Any

from palpate.calibration import AccuracySpec, PredictedAccuracy, ToleranceSpec, predict_accuracy
from palpate.core import ArtefactStore, PalpateError, Recipe, atomic_write, stage_version
from palpate.design import Design, SkinSpec, Symmetry
from palpate.fea import Branch, WallSpec, read_press
from palpate.study.study import AsBuiltSpec, Study
from palpate.study.task import PressTask, Task, find_artefact, write_json
from palpate.surrogate import (
    build_twin,
    measure_interpolation_error,
    read_twin,
    twin_derivatives,
    twin_path,
    twin_version,
    write_twin,
)

_PREDICTION_TILTS, _PREDICTION_CONTACTS = 3, ("no-slip", 0.8)
"""Tilts and contact laws of the presses from which the accuracy of built units is predicted.

The frictions of the default tolerances are between these laws. By hand.
"""
_FEWEST_IMAGES = 5
"""Minimum increments of a press for a prediction; with fewer, the depth step is halved. By hand."""
_STEP_SHARE = 0.5
"""Depth step of a press for reading images, over that of the study.

The unit of `examples/data` is read with 0.012 and 0.008° RMSE after identification by a twin of 28 presses with this
share, with 0.016 and 0.010° with 1, which saves 8 % of the CPU time.
"""
_CHECK_SHARE, _INVERTED_SHARE = 0.75, 0.25
"""Depth step of validation presses and of the inverted branch, over that of the study. By hand.

Every second increment of a validation press is half-way between two of a twin for reading images.
"""
_TURN_DEG = 77.0
"""Azimuth of the first validation press, and difference between successive ones. By hand."""
_ROUND = 2
"""Core of an inverted skin's mesh; four cells along half a turn cause waves of 0.07 mm in order 4."""


@dataclass(frozen=True)
class TwinTask(Task):
    """Make the twin of one skin from presses at every tilt and friction, and of its inverted state."""

    presses: tuple[PressTask, ...]
    inverted: tuple[PressTask, ...] = ()
    checks: tuple[PressTask, ...] = ()

    @property
    def name(self) -> str:
        return f"twin {self.presses[0].design.skin.name}"

    @cached_property
    def recipe(self) -> Recipe:
        keys = tuple(press.recipe.key for press in self.dependencies)
        return Recipe(kind="twin", spec={}, inputs=keys, version=twin_version())

    @property
    def dependencies(self) -> tuple[PressTask, ...]:
        return (*self.presses, *self.inverted, *self.checks)

    @property
    def cost(self) -> float:
        return 0.05 * len(self.dependencies)

    def make(self, store: ArtefactStore) -> None:
        flat, inverted, checks = (
            [read_press(find_artefact(store, press)) for press in presses]
            for presses in (self.presses, self.inverted, self.checks)
        )
        twin = build_twin(flat, inverted)
        twin = replace(twin, interpolation_error_mm=measure_interpolation_error(twin, checks))
        store.write(self.recipe, lambda path: write_twin(path, twin))


@dataclass(frozen=True)
class AccuracyTask(Task):
    """Predict the accuracy of built units of one design, without and with calibration presses."""

    twin: TwinTask
    design: Design
    tolerance: ToleranceSpec
    specs: tuple[AccuracySpec, ...]

    suffix = ".json"

    @property
    def name(self) -> str:
        return f"built units of {self.design.skin.name} {len(self.design.layout)} markers"

    @cached_property
    def recipe(self) -> Recipe:
        layout = self.design.layout
        spec = {
            "markers_mm": layout.positions.tolist(),
            "diameter": layout.diameter,
            "camera": self.design.camera_spec.model_dump(mode="json"),
            "tolerance": self.tolerance.model_dump(mode="json"),
            "figures": [asdict(figure) for figure in self.specs],
        }
        return Recipe(kind="built", spec=spec, inputs=(self.twin.recipe.key,), version=stage_version("accuracy"))

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return (self.twin,)

    @property
    def cost(self) -> float:
        return 0.5

    def make(self, store: ArtefactStore) -> None:
        twin = read_twin(find_artefact(store, self.twin))
        layout, camera = self.design.layout, self.design.camera
        found = [asdict(predict_accuracy(twin, layout, camera, self.tolerance, spec)) for spec in self.specs]
        store.write(self.recipe, lambda path: write_json(path, found), self.suffix)


def read_accuracy(path: Path) -> tuple[PredictedAccuracy, ...]:
    """Read the result of an `AccuracyTask`."""
    return tuple(PredictedAccuracy(**figure) for figure in json.loads(path.read_text(encoding="utf-8")))


def plan_prediction(study: Study, skin: SkinSpec) -> TwinTask | None:
    """The twin for the predicted accuracy of built units of a skin.

    If the study gives `built`, the twin for reading images. Otherwise a twin of three of the study's tilts without
    slip and under one friction; `None` if the skin is not of revolution, the obstacle is not a wall, or the study has
    fewer than three tilts from 0.

    Raises
    ------
    PalpateError
        If `built` is given, and the skin or the obstacle has no twin.
    """
    tilts = study.tilts_deg
    if study.built is None:
        return None
    if "built" in study.model_fields_set:
        return plan_twin(study, skin)
    if (
        skin.build().symmetry is not Symmetry.REVOLVED
        or skin.build().hole
        or not _is_flat_wall(study)
        or len(tilts) < _PREDICTION_TILTS
        or tilts[0] != 0.0
    ):
        return None
    middle = min(_twin_tilts(study)[1:-1], key=lambda tilt: (abs(tilt - 0.5 * tilts[-1]), -tilt))
    share = 1.0 if study.obstacle.depth >= _FEWEST_IMAGES * study.obstacle.depth_step else _STEP_SHARE
    presses = _plan_presses(study, skin, (0.0, middle, tilts[-1]), _PREDICTION_CONTACTS, share)
    return TwinTask(tuple(presses))


def _twin_tilts(study: Study) -> tuple[float, ...]:
    """Tilts of a study that a twin needs, at least four if it has as many."""
    tilts, step_deg = study.tilts_deg, (study.built or AsBuiltSpec()).tilt_step_deg
    found = [tilts[0]]
    for tilt, following in pairwise(tilts):
        if following - found[-1] > step_deg and tilt > found[-1]:
            found.append(tilt)
    found.append(tilts[-1])
    return tuple(found) if len(found) > _PREDICTION_TILTS else tuple(tilts)


def _is_flat_wall(study: Study) -> bool:
    return isinstance(study.obstacle, WallSpec) and study.obstacle.curvature == 0.0


def plan_twin(study: Study, skin: SkinSpec, step_share: float = _STEP_SHARE) -> TwinTask:
    """The twin of one skin for reading images.

    Parameters
    ----------
    study, skin
        The study, and one of its skins.
    step_share
        Depth step of the presses over that of the study; they are equal steps to the study's depth.

    Raises
    ------
    PalpateError
        If the skin is no body of revolution, or the obstacle is no wall.
    """
    skin.build().require_revolution(
        "a twin has one press a tilt for all azimuths",
        "Leave the twin out: `palpate run` without `built` reads its presses by azimuth and trains on them.",
        code="twin-needs-revolution",
    )
    if not _is_flat_wall(study):
        raise PalpateError(
            f"A twin is made of presses by a flat wall, and the obstacle of {study.name} is {study.obstacle.label}.",
            "Leave the obstacle out, or train an estimator for it: `palpate run`.",
            code="twin-needs-wall",
        )
    asked = study.built or AsBuiltSpec()
    inverted = tuple(_plan_inverted(study, skin)) if asked.inverted and not study.material.gel else ()
    presses = tuple(_plan_presses(study, skin, _twin_tilts(study), asked.contacts, step_share))
    return TwinTask(presses, inverted, tuple(_plan_checks(study, skin, asked)))


def plan_accuracy(study: Study, twin: TwinTask, design: Design) -> AccuracyTask:
    """Plan the accuracy prediction of one design, with its markers counted."""
    asked = study.built or AsBuiltSpec()
    specs = (
        AccuracySpec(calibration_presses=known, max_tilt_deg=study.tilts_deg[-1], seed=study.seed)
        for known in (0, asked.calibration_presses)
    )
    return AccuracyTask(twin, design, asked.tolerance, tuple(specs))


def _plan_presses(
    study: Study,
    skin: SkinSpec,
    tilts: Sequence[float],
    contacts: Sequence[str | float],
    share: float = _STEP_SHARE,
) -> Iterator[PressTask]:
    """Presses with derivatives at every tilt and contact law, in equal steps of a share of the study's.

    A twin ends at the last whole step, which is the depth of the study then.
    """
    depth = study.obstacle.depth
    step = depth / ceil(depth / (share * study.obstacle.depth_step) - 1e-6)
    slippery = study.obstacle.contact == "frictionless"
    mesh = study.material.mesh(study.mesh)
    for contact in (study.obstacle.contact,) if slippery else contacts:
        for tilt_deg in tilts:
            changed = {"tilt_deg": tilt_deg, "contact": contact, "depth_step": step}
            obstacle = study.obstacle.model_copy(update=changed)
            derivatives = twin_derivatives(mesh.filled, obstacle.friction)
            yield PressTask(
                design=study.design(skin),
                mesh=mesh,
                obstacle=obstacle,
                solver=study.solver.model_copy(update={"derivatives": derivatives}),
            )


def _plan_checks(study: Study, skin: SkinSpec, asked: AsBuiltSpec) -> Iterator[PressTask]:
    """Validation presses between those of the twin, in other directions, over its tilts and frictions.

    Half of their increments are between those of the twin, too.
    """
    slips = sorted(0.0 if contact == "no-slip" else 1.0 / float(contact) for contact in asked.contacts)
    for number in range(asked.checks):
        share = (number + 0.5) / asked.checks
        tilt, slip = (_between(values, share) for values in (_twin_tilts(study), slips))
        turn_deg, step = _TURN_DEG * (number + 1) % 360.0, _CHECK_SHARE * study.obstacle.depth_step
        changed: dict[str, Any] = {"tilt_deg": tilt, "azimuth_deg": turn_deg, "depth_step": step}
        if study.obstacle.contact != "frictionless":
            changed["contact"] = round(1.0 / slip, 6) if slip > 0 else "no-slip"
        yield PressTask(
            design=study.design(skin),
            mesh=study.material.mesh(study.mesh),
            obstacle=study.obstacle.model_copy(update=changed),
            solver=study.solver,
        )


def _between(values: Sequence[float], share: float) -> float:
    """Middle of the step at a share of ascending values."""
    step = min(int(share * (len(values) - 1)), len(values) - 2)
    return 0.5 * (values[step] + values[step + 1]) if len(values) > 1 else values[0]


def _plan_inverted(study: Study, skin: SkinSpec) -> Iterator[PressTask]:
    """Presses of the inverted state, which are the same under every contact law."""
    mesh = study.mesh if study.mesh.core else study.mesh.model_copy(update={"core": _ROUND})
    for tilt_deg in _twin_tilts(study):
        changed = {"tilt_deg": tilt_deg, "depth_step": _INVERTED_SHARE * study.obstacle.depth_step}
        yield PressTask(
            design=study.design(skin),
            mesh=mesh,
            obstacle=study.obstacle.model_copy(update=changed),
            solver=study.solver.model_copy(update={"derivatives": twin_derivatives(filled=False)}),
            branch=Branch.INVERTED,
        )


def export_twins(folder: Path, twins: Iterable[tuple[SkinSpec, Path]]) -> None:
    """Copy twins into a result folder, under the names that the sensor and the viewer look for."""
    for skin, made in twins:
        kept = twin_path(folder, skin.build())
        kept.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(kept) as draft:
            shutil.copyfile(made, draft)
