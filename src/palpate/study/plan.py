"""Tasks of a study, with presses shared between designs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from palpate.core import PalpateError
from palpate.design import (
    MarkerSpec,
    Skin,
    SkinSpec,
    Symmetry,
    build_skin,
    check_design,
    place_markers,
    raise_on_errors,
)
from palpate.fea import Branch, obstacle_from_data
from palpate.study.accuracy_task import AccuracyTask, plan_accuracy, plan_prediction, plan_twin
from palpate.study.force_task import ForceTask
from palpate.study.study import Study
from palpate.study.task import DatasetTask, EvaluationTask, PressTask, Task


@dataclass(frozen=True)
class Plan:
    """The tasks of a study, in the order of its designs.

    Attributes
    ----------
    designs
        The last task of each design; it depends on the remaining ones.
    built
        Predicted accuracy of built units of each design; `None` without a prediction.
    forces
        Force training of each design's estimator; `None` without it.
    """

    designs: tuple[EvaluationTask, ...]
    built: tuple[AccuracyTask | None, ...]
    forces: tuple[ForceTask, ...] = ()

    def tasks(self) -> tuple[Task, ...]:
        """Return every task once, each after its dependencies."""
        return with_dependencies(
            [*self.designs, *filter(None, self.built), *self.forces, *(design.inverted for design in self.designs)]
        )

    def read_at_the_end(self) -> tuple[Task, ...]:
        """Return the tasks whose artefacts the records of the designs are read from, each once."""
        unique: dict[str, Task] = {}
        for design in self.designs:
            for task in (*design.dataset.presses, design.inverted, design.bound, design):
                unique.setdefault(task.recipe.key, task)
        for more in (*filter(None, self.built), *self.forces):
            unique.setdefault(more.recipe.key, more)
        return tuple(unique.values())

    def bound_tasks(self) -> tuple[Task, ...]:
        """Return the bound tasks of all designs with their dependencies, each once, in order."""
        return with_dependencies([design.bound for design in self.designs])


def plan_study(study: Study) -> Plan:
    """Plan the tasks of `study`.

    Returns
    -------
    Plan
        One press a skin and tilt (and azimuth, of a skin that is not of revolution), and the inverted state at the
        minimum tilt; one dataset, bound, estimator and evaluation a design.

    Raises
    ------
    PalpateError
        If a design cannot be built, which the message names, or all images of a press are left out.
    """
    study = study.seeded()
    _refuse_no_image(study)
    designs, built = [], []
    for skin in study.designs.skins():
        _refuse_unfit(study, skin.build())
        twin = plan_prediction(study, skin)
        shared = {press.obstacle: press for press in (twin.presses if twin else ())}  # the same, with derivatives
        presses = tuple(shared.get(press.obstacle, press) for press in _plan_presses(study, skin))
        relatives = tuple(tuple(group) for group in _plan_relatives(study, skin))
        straight = min(presses, key=lambda press: press.obstacle.radial)
        # a filled skin has one state; of a barrel only the one pressed from rest is followed
        alone = study.material.gel or skin.build().hole
        inverted = straight if alone else replace(straight, branch=Branch.INVERTED)
        for given in study.designs.markers:
            design = study.design(skin, check_markers(skin, given))
            dataset = DatasetTask(presses, design, study.dataset, relatives)
            designs.append(EvaluationTask(dataset=dataset, spec=study.learning, inverted=inverted))
            built.append(plan_accuracy(study, twin, design) if twin else None)
    forces = tuple(ForceTask(design.estimator) for design in designs) if study.forces else ()
    return Plan(designs=tuple(designs), built=tuple(built), forces=forces)


def plan_reading_twins(study: Study) -> tuple[AccuracyTask, ...]:
    """Plan the twins of a study and the accuracy predicted from them.

    Raises
    ------
    PalpateError
        If a design cannot be built, or a skin or obstacle has no twin.
    """
    study = study.seeded()
    found = []
    for skin in study.designs.skins():
        _refuse_unfit(study, skin.build())
        twin = plan_twin(study, skin)
        for markers in study.designs.markers:
            found.append(plan_accuracy(study, twin, study.design(skin, check_markers(skin, markers))))
    return tuple(found)


def _refuse_no_image(study: Study) -> None:
    """Reject a study that leaves out all images of its presses, before they are solved."""
    steps = study.obstacle.depth / study.obstacle.depth_step
    images = int(steps + 2 * np.spacing(steps))  # 2.4 mm are three steps of 0.8 mm
    if images <= study.dataset.dropped_images:
        raise PalpateError(
            f"A press of {study.obstacle.depth:g} mm by {study.obstacle.depth_step:g} mm has {images} images; "
            f"dataset.dropped_images leaves out {study.dataset.dropped_images}.",
            "Press deeper, shorten depth_step, or leave out fewer images.",
            code="dataset-no-image",
        )


def _refuse_unfit(study: Study, skin: Skin) -> None:
    """Reject settings of a study that the skin does not allow, with a `PalpateError`."""
    for position in study.positions:
        study.obstacle_at(position).check_skin(skin, study.mesh.rim)
    if skin.symmetry is not Symmetry.REVOLVED and not study.obstacle.pose_space.is_tilt:
        raise PalpateError(
            f"{skin.name} is not a body of revolution: a study presses it by flat walls, not by "
            f"{study.obstacle.label}.",
            "Leave `obstacle` out of the study, or use `palpate press --obstacle` for single presses.",
            code="study-needs-flat-wall",
        )
    if skin.hole and study.material.gel:
        raise PalpateError(
            f"{skin.name} is open at both ends: a filling is not meshed.",
            "Leave the gel out.",
            code="filling-needs-apex",
        )
    if study.forces:
        skin.require_revolution(
            "its forces are not interpolated", "Leave `forces` out of the study.", code="forces-need-revolution"
        )


def _plan_presses(study: Study, skin: SkinSpec) -> Iterator[PressTask]:
    mesh = study.material.mesh(study.mesh)
    for position, azimuth_deg in _poses(study, build_skin(skin)):
        turned = {"azimuth_deg": azimuth_deg} if azimuth_deg else {}
        yield PressTask(
            design=study.design(skin),
            # half a skin is symmetric about the plane of the tilt
            mesh=mesh.model_copy(update={"whole": True}) if azimuth_deg or not study.obstacle.mirrored else mesh,
            obstacle=study.obstacle_at(position, **turned),
            solver=study.solver,
        )


def _poses(study: Study, skin: Skin) -> Iterator[tuple[float, float]]:
    """Position and azimuth (degrees) of every press; one azimuth if it serves all."""
    for position in study.positions:
        one = position == 0 or skin.symmetry is Symmetry.REVOLVED
        for azimuth_deg in (0.0,) if one else study.azimuths_deg:
            yield position, azimuth_deg


def _plan_relatives(study: Study, skin: SkinSpec) -> Iterator[Iterator[PressTask]]:
    """Presses for `RandomisationSpec`: other frictions, thinner, thicker, other obstacles."""
    varied = study.dataset.randomise
    if varied is None:
        return
    for friction in varied.frictions:
        yield _plan_presses(study.with_contact(friction), skin)
    for step in (-varied.thickness, varied.thickness) if varied.thickness else ():
        other = type(skin).model_validate(skin.model_dump() | {"thickness": skin.thickness + step})
        yield _plan_presses(study, other)
    travel = study.obstacle.model_dump(include={"depth", "depth_step", "contact"})
    for given in varied.obstacles:
        obstacle = obstacle_from_data(travel | given)
        if obstacle.pose_space != study.obstacle.pose_space:
            raise PalpateError(
                f"A dataset under {study.obstacle.label} is not randomised by this obstacle: {obstacle.label}.",
                "Use obstacles whose pose has the same components.",
                code="obstacle-pose-differs",
            )
        obstacle.check_skin(build_skin(skin), study.mesh.rim)
        yield _plan_presses(study.model_copy(update={"obstacle": obstacle}), skin)


def check_markers(dome_spec: SkinSpec, markers: MarkerSpec) -> MarkerSpec:
    """Return the layout with its number of markers counted, after a check of the design."""
    skin = build_skin(dome_spec)
    layout = place_markers(skin, markers)
    try:
        raise_on_errors(check_design(skin, layout))
    except PalpateError as error:
        raise PalpateError(
            f"Design {dome_spec.build().name}: {error.problem}", error.remedy, code=error.code
        ) from None
    return markers.model_copy(update={"count": len(layout)})


def with_dependencies(last: Sequence[Task]) -> tuple[Task, ...]:
    """Return these tasks and their dependencies, each once and after its own dependencies."""
    unique: dict[str, Task] = {}
    for end in last:
        for task in _needs_first(end):
            unique.setdefault(task.recipe.key, task)
    return tuple(unique.values())


def _needs_first(task: Task) -> Iterator[Task]:
    for need in task.dependencies:
        yield from _needs_first(need)
    yield task
