"""Fine-tuning of a pretrained estimator on markers to a unit by few presses.

The estimator comes from another recording, or from images of the simulated design; `palpate.learn.simulated_start`
trains one on the simulation itself. The pretrained layout at rest is matched to
this unit's blobs (`palpate.vision.match_markers`); the linear map between both rest images transforms displacements,
which removes differences of camera and print. With very few presses only a linear correction of its outputs is
fitted. With more, a network is trained further, at a low rate and regularised towards its initial weights; to a
Gaussian process another one is added, of its errors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError
from palpate.core.run import Progress
from palpate.learn.estimator import Estimator
from palpate.learn.io import read_estimator
from palpate.learn.learning_curve import CurvePoint, compute_learning_curve
from palpate.learn.member import MarkerNetwork, MarkerProcess
from palpate.learn.prepare_recording import PreparedRecording
from palpate.learn.recording_model import read_model
from palpate.learn.ridge import solve_ridge
from palpate.learn.simulated_start import SimulatedStart
from palpate.learn.training_set import TrainingSet
from palpate.vision import MarkerMatcher, ObservedLayout

ADAPTED, CORRECTED = "adapted", "corrected"
_HOLD = 0.05
"""Weight of the regularisation of the linear correction, over the number of training presses. By hand."""
_DENSITY = 2.5
"""Maximum scale factor between the two rest images. By hand."""


@dataclass(frozen=True, eq=False)
class PretrainedModel:
    """Pretrained model.

    Attributes
    ----------
    name
        Its file.
    layout
        Its markers at rest, px of its own camera.
    estimator
        Its estimator on markers.
    outputs
        Names of its outputs, ``rx_deg`` …
    """

    name: str
    layout: ObservedLayout
    estimator: MarkerNetwork | MarkerProcess
    outputs: tuple[str, ...]


def read_pretrained(path: Path) -> PretrainedModel:
    """Read the model of a recording (.h5) or a network trained on simulated images (.onnx).

    Raises
    ------
    PalpateError
        If it is neither, or has no marker network.
    """
    if path.suffix == ".onnx":
        return _of_simulation(path.name, read_estimator(path))
    model = read_model(path)
    parts, used = list(model.parts.values()), model.marker_ensemble
    if used is not None:
        share = dict(zip(used.parts, used.weights.mean(axis=1), strict=True))
        parts.sort(key=lambda one: -share.get(one.name, 0.0))
    found: list[MarkerNetwork | MarkerProcess] = [one for one in parts if isinstance(one, MarkerNetwork)]
    found += [one for one in parts if isinstance(one, MarkerProcess)]
    if not found or model.layout is None:
        raise PalpateError(
            f"{path.name} has no network or process on markers; it has {', '.join(model.parts)}.",
            "Give a model whose best estimator reads markers.",
            code="model-no-marker-network",
        )
    return PretrainedModel(path.name, model.layout, found[0], model.space.names)


def _of_simulation(name: str, found: Estimator) -> PretrainedModel:
    """Convert a simulation's network to one on displacements: it reads (rest + moved − offset) / scale."""
    scale = np.tile(np.array(found.normalisation.scale_px), len(found.rest_px))
    at_rest = found.normalisation.apply(found.rest_px).reshape(-1)
    arrays: dict[str, NDArray[Any]] = {"projection": np.diag(1.0 / scale), "offset": -at_rest}
    for number, (weight, bias) in enumerate(zip(found.weights, found.biases, strict=True)):
        arrays |= {f"weight_{number}": weight, f"bias_{number}": bias}
    arrays |= {"mean": found.output_mean, "sd": found.output_sd}
    arrays |= {"relu": np.array(1)} if found.activation == "relu" else {}
    return PretrainedModel(
        name, ObservedLayout(found.rest_px), MarkerNetwork("dots-network", arrays), found.space.names
    )


def transfer_estimator(start: PretrainedModel, seen: PreparedRecording) -> MarkerNetwork | MarkerProcess:
    """Return the pretrained estimator for this unit's displacements and this recording's outputs.

    Raises
    ------
    PalpateError
        If its layout does not match this unit's rest image, or it estimates other quantities.
    """
    assert seen.assigned is not None
    wanted = tuple(f"{one.axis}_{one.unit}" for one in seen.recording.poses)
    if any(name not in start.outputs for name in wanted):
        raise PalpateError(
            f"{start.name} estimates {', '.join(start.outputs)}, not {', '.join(wanted)}.",
            "Choose by --targets.",
            code="model-outputs-differ",
        )
    own, other = seen.assigned.layout.rest_px, start.layout.rest_px
    scale = float(np.median(seen.assigned.layout.spacing_px) / np.median(start.layout.spacing_px))
    if not 1 / _DENSITY < scale < _DENSITY:
        raise PalpateError(
            f"The markers of {start.name} are {scale:.2g} times as dense.",
            "Give a unit of the same make.",
            code="rest-markers-density",
        )
    shrunk = (own - own.mean(axis=0)) / scale + other.mean(axis=0)
    found = MarkerMatcher(start.layout, seen.eye.shape).find(shrunk)
    if not found.accepted:
        raise PalpateError(
            f"The markers at rest do not match {start.name}: {found.fault} ({found.agreement:.0%} agree).",
            "Give a unit of the same make, its camera turned by less than half the angle between two markers.",
            code="rest-markers-differ",
        )
    placed = start.layout.rest_px + found.moved_px
    number = np.argmin(np.linalg.norm(placed[:, None] - shrunk[None], axis=-1), axis=1)
    design = np.column_stack([other[found.found], np.ones(found.found.sum())])
    own_from_other = np.linalg.lstsq(design, own[number[found.found]], rcond=None)[0][:2]
    back = np.linalg.inv(own_from_other)
    carried = np.zeros((len(own), 2, len(other), 2))
    for dot, place in enumerate(number):
        carried[place, :, dot, :] = back
    chosen = np.eye(len(start.outputs))[:, [start.outputs.index(name) for name in wanted]]
    matrix = carried.reshape(2 * len(own), 2 * len(other))
    return start.estimator.transform_inputs(matrix).transform_outputs("carried", chosen, np.zeros(len(wanted)))


def fine_tune_members(
    start: PretrainedModel | SimulatedStart, seen: PreparedRecording, progress: Progress, few: bool = False
) -> dict[str, MarkerNetwork | MarkerProcess]:
    """Return the corrected and the fine-tuned estimator by name, or that of a corrected simulation.

    A simulation makes no choices on validation presses: if there are few presses, these train it as well.

    Raises
    ------
    PalpateError
        If the layouts do not match, or this recording has no assigned markers.
    """
    if seen.assigned is None:
        raise PalpateError(
            "The recording has no assigned markers for fine-tuning.",
            "Train without --from.",
            code="recording-markers-unassigned",
        )
    lesson, _ = seen.samples(markers=True)
    if isinstance(start, SimulatedStart):
        train = lesson.train | lesson.validation if few else lesson.train
        parts: list[MarkerNetwork | MarkerProcess] = [start.train(seen, replace(lesson, train=train))]
    else:
        carried = transfer_estimator(start, seen)
        parts = [_correct(carried, lesson), _adapt(carried, lesson)]
    found = {part.name: part for part in parts}
    for name, part in found.items():
        error = lesson.error(part.predict(seen.moved[lesson.chosen_by]))
        progress.note(f"{name}: validation error {error:.4f} of the deviation")
    return found


def _correct(carried: MarkerNetwork | MarkerProcess, lesson: TrainingSet) -> MarkerNetwork | MarkerProcess:
    """Fit outputs a + B y by least squares on the training set, regularised towards B = 1."""
    given = carried.predict(lesson.inputs[lesson.train])
    scale = lesson.scale[1]
    residual = (lesson.targets[lesson.train] - given) / scale
    [(change, shift)] = solve_ridge(given / scale, residual, [_HOLD * len(given) ** 0.5])
    turn = (np.eye(len(scale)) + change) * scale / scale[:, None]
    return carried.transform_outputs(f"{CORRECTED}-{carried.kind}", turn, shift * scale)


def _adapt(carried: MarkerNetwork | MarkerProcess, lesson: TrainingSet) -> MarkerNetwork | MarkerProcess:
    return _correct(carried, lesson).fine_tune(f"{ADAPTED}-{carried.kind}", lesson)


def compute_fine_tuning_curve(
    start: PretrainedModel | SimulatedStart, seen: PreparedRecording
) -> tuple[CurvePoint, ...]:
    """Errors on the test presses, if there are any, of the start and with more and more presses."""
    if seen.assigned is None:
        return ()
    samples, test = seen.samples(markers=True)
    if not (samples.train.any() and samples.validation.any() and test.any()):
        return ()
    if isinstance(start, SimulatedStart):
        carried: MarkerNetwork | MarkerProcess = start.train(
            seen, replace(samples, train=np.zeros_like(samples.train))
        )
        adapt: Callable[[TrainingSet], MarkerNetwork | MarkerProcess] = partial(start.train, seen)
    else:
        carried = transfer_estimator(start, seen)
        adapt = partial(_adapt, carried)
    errors: FloatArray = carried.predict(seen.moved[test]) - seen.targets[test]
    first = CurvePoint(0, f"{start.name} as it is", tuple(float(x) for x in np.sqrt(np.mean(errors**2, axis=0))))
    adapted = compute_learning_curve(samples, seen.press, test, lambda some, _: [adapt(some)])
    return (first, *(replace(point, estimator="adapted") for point in adapted))
