"""Evaluation of one skin: coarse presses, twin, rings and camera, predicted accuracy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from palpate.calibration import (
    AccuracySpec,
    ContradictionError,
    PredictedAccuracy,
    ValidationPresses,
    predict_accuracy,
    sample_deviation,
)
from palpate.camera import Camera, build_camera
from palpate.core import ArtefactStore, MissingExtraError, PalpateError, Recipe, stage_version
from palpate.design import (
    Design,
    MarkerSpec,
    Severity,
    SkinSpec,
    markers_in_rings,
    place_markers,
    ring_diameters,
)
from palpate.fabrication import check_process
from palpate.fea import Branch, Press, read_press
from palpate.material import get_material
from palpate.mesh import MeshSpec
from palpate.optimise.camera_setting import CameraSetting, measure_settings, rank_settings
from palpate.optimise.choose_rings import choose_rings, space_rings_evenly
from palpate.optimise.skin_evaluation import LayoutOption, SkinEvaluation
from palpate.optimise.spec import BaselineGridSpec, RequirementsSpec
from palpate.optimise.validation_presses import ValidationPressTasks, plan_validation_presses
from palpate.sensor import Unit, open_sensor
from palpate.simulation import DEGRADED, SimulatedUnit
from palpate.study import (
    AsBuiltSpec,
    MaterialSpec,
    PressTask,
    Study,
    Task,
    TwinTask,
    find_artefact,
    plan_twin,
    write_json,
)
from palpate.surrogate import Twin, read_twin

_COARSE_TILTS, _COARSE_CONTACTS, _COARSE_CELLS = 4, ("no-slip", 0.8, 0.2), 10
"""Tilts, contact laws and cells along a meridian of the coarse presses of the search.

The finalists are evaluated again by the presses of a twin that reads images. By hand.
"""
_EVALUATED_BY = (
    "seed",
    "calibration_presses",
    "min_depth",
    "depth",
    "max_tilt_deg",
    "markers",
    "min_marker_diameter",
    "max_marker_diameter",
    "cameras",
    "tolerance",
    "process",
)
"""Requirements that change the evaluation of a skin; the remaining ones only select among evaluations."""
_LOOKED_AT, _LOOKED_AT_FULLY = 3, 20
"""Units whose rest images are read before a layout is offered: coarse, and at full fidelity. By hand."""
_FIRST_UNIT = 1001
"""First of these units; no validation simulates it."""
_SETTINGS = 3
"""Number of best settings in which rings are exchanged until a layout is readable. By hand."""


@dataclass(frozen=True)
class SkinEvaluationTask(Task):
    """Choose rings and camera of one skin, and predict the accuracy of its units."""

    twin: TwinTask
    inverted: PressTask | None
    spec: RequirementsSpec
    material: str
    grid: BaselineGridSpec | None = None
    """Grid whose layouts and camera are evaluated; without it, rings and camera are chosen."""
    checks: tuple[ValidationPressTasks, ...] = ()
    """Presses that measure the twin error; without them, that of one design on the test bench is assumed."""

    suffix = ".json"

    @property
    def skin(self) -> SkinSpec:
        """The skin that is evaluated."""
        return self.twin.presses[0].design.skin_spec

    @property
    def name(self) -> str:
        return f"proposal {self.skin.build().name}"

    @cached_property
    def recipe(self) -> Recipe:
        spec = self.spec.model_dump(mode="json", include=set(_EVALUATED_BY)) | {"material": self.material}
        if self.grid is not None:
            spec["baseline_grid"] = self.grid.model_dump(
                mode="json", include={"designs": {"markers"}, "distance": True}
            )
        inputs = tuple(task.recipe.key for task in self.dependencies)
        return Recipe(kind="proposal", spec=spec, inputs=inputs, version=stage_version("skin_evaluation"))

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return (
            self.twin,
            *((self.inverted,) if self.inverted else ()),
            *(press for checks in self.checks for press in checks.presses),
        )

    @property
    def cost(self) -> float:
        rings = self.spec.markers**0.5  # measured at 19 and 169 markers, with presses to check at 37
        return 0.75 * rings * len(self.spec.cameras) * (5.0 if self.checks else 1.0)

    def make(self, store: ArtefactStore) -> None:
        presses = [read_press(find_artefact(store, press)) for press in self.twin.presses]
        force = max(float(np.linalg.norm(press.force, axis=1).max()) for press in presses)
        twin = read_twin(find_artefact(store, self.twin))
        second = find_bistable_from(read_press(find_artefact(store, self.inverted))) if self.inverted else None
        known = SkinEvaluation(self.skin, self.material, float(twin.max_depth_mm.min()), force, second)
        checks = [each.find(store) for each in self.checks]
        proposal = evaluate_skin(twin, known, self.spec, self.grid, checks)
        store.write(self.recipe, lambda path: write_json(path, proposal.to_data()), self.suffix)


def plan_skin_evaluation(
    spec: RequirementsSpec, skin: SkinSpec, material: str, *, full: bool = False, grid: BaselineGridSpec | None = None
) -> SkinEvaluationTask:
    """Plan the tasks that evaluate a skin.

    Parameters
    ----------
    spec
        The requirements.
    skin, material
        The skin.
    full
        Whether the presses are those of a study's twin, with validation presses, instead of fewer and coarser ones.
    grid
        Grid whose layouts and camera are evaluated; without it, rings and camera are chosen.
    """
    tilts = 7 if full else _COARSE_TILTS
    step = spec.depth / (10.0 if full else 5.0)
    study = Study(
        name=spec.name,
        material=MaterialSpec(name=material),
        mesh=MeshSpec() if full else MeshSpec(cells=_COARSE_CELLS),
        tilts_deg=tuple(round(float(tilt), 6) for tilt in np.linspace(0.0, spec.max_tilt_deg, tilts)),
        built=AsBuiltSpec(tilt_step_deg=0.0, inverted=False)
        if full
        else AsBuiltSpec(tilt_step_deg=0.0, contacts=_COARSE_CONTACTS, checks=0, inverted=False),
    )
    study = study.model_copy(
        update={"obstacle": study.obstacle.model_copy(update={"depth": spec.depth, "depth_step": step})}
    )
    twin = plan_twin(study, skin) if full else plan_twin(study, skin, step_share=1.0)
    straight = twin.presses[0]
    plain = straight.solver.model_copy(update={"derivatives": ()})
    inverted = replace(straight, solver=plain, branch=Branch.INVERTED)
    checks = plan_validation_presses(twin, spec) if full else ()
    return SkinEvaluationTask(twin, inverted if spec.single_state else None, spec, material, grid, checks)


def evaluate_skin(
    twin: Twin,
    known: SkinEvaluation,
    spec: RequirementsSpec,
    grid: BaselineGridSpec | None = None,
    checks: Sequence[ValidationPresses] = (),
) -> SkinEvaluation:
    """Choose markers and camera on a twin's skin for every number of rings, and predict their accuracy.

    If nothing can be printed on the skin, or the skin cannot be made, the result contains this problem instead.

    Parameters
    ----------
    twin
        Twin of the skin.
    known
        Evaluation of its presses.
    spec
        The requirements.
    grid
        Grid whose layouts and camera are used unchanged.
    checks
        Presses that measure the twin error.
    """
    try:
        options = _choose(twin, known.material, spec, checks) if grid is None else _as_given(twin, spec, grid)
        return replace(known, options=tuple(options))
    except MissingExtraError:
        raise
    except PalpateError as error:
        return replace(known, problem=str(error.problem))


def _choose(
    twin: Twin, material: str, spec: RequirementsSpec, checks: Sequence[ValidationPresses]
) -> Iterator[LayoutOption]:
    """Yield the best readable option of each camera and number of rings."""
    problems, found = [], False
    for choice in spec.cameras:
        settings = tuple(measure_settings(twin, spec, choice, accuracy_spec(spec)))
        for rings in range(1, settings[0].places.limits.rings + 1):
            problem = PalpateError(
                f"{markers_in_rings(rings)} markers cannot be printed on this skin and be seen apart by the camera "
                f"{choice.name}.",
                "Allow a greater distance, smaller markers, or a larger skin.",
                code="markers-not-printable",
            )
            for camera, markers in _offers(settings, markers_in_rings(rings)):
                refusal = _refuse(twin, markers, material, camera, spec, _LOOKED_AT_FULLY if checks else _LOOKED_AT)
                figure = refusal or _predict(twin, markers, camera, spec, checks)
                if isinstance(figure, PredictedAccuracy):
                    found = True
                    yield LayoutOption(markers, choice.name, camera.spec.distance, choice.price, figure)
                    break
                problem = figure
            problems.append(problem)
    if not found:
        raise problems[0]


def _as_given(twin: Twin, spec: RequirementsSpec, grid: BaselineGridSpec) -> Iterator[LayoutOption]:
    """Yield the layouts of a grid with its camera, up to the permitted number of markers."""
    choice = spec.cameras[0]
    camera = build_camera(choice.camera.model_copy(update={"distance": grid.distance}))
    for given in grid.designs.markers:
        if given.count <= spec.markers:
            rings = given.ring_diameters or ring_diameters(given.count, twin.skin.base_radius)
            markers = given.model_copy(update={"ring_diameters": rings})
            layout = place_markers(twin.skin, markers)
            figure = predict_accuracy(twin, layout, camera, spec.tolerance, accuracy_spec(spec))
            yield LayoutOption(markers, choice.name, grid.distance, choice.price, figure)


def _offers(settings: Sequence[CameraSetting], markers: int) -> Iterator[tuple[Camera, MarkerSpec]]:
    """Yield layouts of this many markers with their camera, best first, then evenly spaced rings.

    Settings are ranked by evenly spaced rings, and rings are exchanged in the best few.
    """
    for setting in rank_settings(settings, markers)[:_SETTINGS]:
        for choose in (choose_rings, space_rings_evenly):
            yield setting.camera, choose(setting.places, markers).markers


def _refuse(
    twin: Twin, markers: MarkerSpec, material: str, camera: Camera, spec: RequirementsSpec, units: int
) -> PalpateError | None:
    """Return the reason to reject a layout: it cannot be made, or a unit cannot be read at rest."""
    design = Design.of_skin(twin.skin, markers, camera.spec, get_material(material))
    for finding in check_process(design, spec.process):
        if finding.severity is Severity.ERROR:
            return PalpateError(finding.message, finding.remedy, code=finding.code)
    unit = Unit(design, tolerance=spec.tolerance)
    for number in range(_FIRST_UNIT, _FIRST_UNIT + units):
        deviation = sample_deviation(spec.tolerance, spec.seed, number)
        rest = SimulatedUnit(design, deviation, DEGRADED).render_rest()
        try:
            open_sensor([rest], unit, twin)
        except MissingExtraError:
            raise
        except PalpateError as error:
            return error
    return None


def find_bistable_from(press: Press) -> float | None:
    """Depth in mm from which a press has the inverted state; `None` if it stays flat."""
    inverted = press.depth[press.branch == Branch.INVERTED]
    return float(inverted.min()) if len(inverted) else None


def accuracy_spec(spec: RequirementsSpec) -> AccuracySpec:
    """Settings of the accuracy prediction; marker noise follows from the marker size in the image."""
    return AccuracySpec(
        calibration_presses=spec.calibration_presses,
        min_depth=spec.min_depth,
        max_tilt_deg=spec.max_tilt_deg,
        scale_noise_by_diameter=True,
        seed=spec.seed,
    )


def _predict(
    twin: Twin, markers: MarkerSpec, camera: Camera, spec: RequirementsSpec, checks: Sequence[ValidationPresses]
) -> PredictedAccuracy | PalpateError:
    """Return the predicted accuracy, or the error if the calibration presses contradict the twin."""
    layout = place_markers(twin.skin, markers)
    try:
        return predict_accuracy(twin, layout, camera, spec.tolerance, accuracy_spec(spec), checks)
    except ContradictionError as error:
        return error
