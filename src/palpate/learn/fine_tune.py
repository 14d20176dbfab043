"""From few presses: a network on dots that was trained elsewhere, adapted to this unit.

The other network knows another unit of the same make: another recording, or the design as simulated. Its dots at rest
are found among this unit's as in any image (`palpate.vision.match_markers`), and the map between both rest images,
linear, carries displacements over: so camera and print of this unit are taken out. Then the network is trained on,
slowly and tied to where it began; with very few presses only its outputs are corrected linearly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError
from palpate.core.run import Progress
from palpate.learn.estimator import Estimator
from palpate.learn.io import read_estimator
from palpate.learn.learning_curve import CurvePoint, compute_learning_curve
from palpate.learn.member import MarkerNetwork
from palpate.learn.prepare_recording import PreparedRecording
from palpate.learn.recording_model import read_model
from palpate.learn.ridge import solve_ridge
from palpate.learn.training_set import TrainingSet
from palpate.vision import MarkerMatcher, ObservedLayout

ADAPTED, CORRECTED = "adapted-dots-network", "corrected-dots-network"
_HOLD = 0.05
"""Weight of a correction's departure from none, over the number of presses that teach."""
_DENSITY = 2.5
"""A rest image of another scale than this factor is not looked for."""


@dataclass(frozen=True, eq=False)
class PretrainedModel:
    """What adaptation begins with.

    Attributes
    ----------
    name
        File that it came from.
    layout
        Its dots at rest, px of its own camera.
    network
        Its network on dots.
    outputs
        Names of its outputs, ``rx_deg`` …
    """

    name: str
    layout: ObservedLayout
    network: MarkerNetwork
    outputs: tuple[str, ...]


def read_pretrained(path: Path) -> PretrainedModel:
    """Read the model of a recording (.h5) or a network that was trained on a simulation (.onnx).

    Raises
    ------
    PalpateError
        If it is neither, or has no network on dots.
    """
    if path.suffix == ".onnx":
        return _of_simulation(path.name, read_estimator(path))
    model = read_model(path)
    found = [part for part in model.parts.values() if isinstance(part, MarkerNetwork)]
    if not found or model.layout is None:
        raise PalpateError(
            f"{path.name} has no network on dots to begin with; it has {', '.join(model.parts)}.",
            "Give a model whose best estimator reads dots.",
            code="model-no-marker-network",
        )
    return PretrainedModel(path.name, model.layout, found[0], model.space.names)


def _of_simulation(name: str, found: Estimator) -> PretrainedModel:
    """A network of the simulation as one on displacements: it reads (rest + moved − offset) / scale."""
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


def transfer_network(start: PretrainedModel, seen: PreparedRecording) -> MarkerNetwork:
    """The other network on this unit's displacements, its outputs in this recording's order.

    Raises
    ------
    PalpateError
        If its dots at rest are not found among this unit's, or it estimates something else.
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
            f"The dots of {start.name} are {scale:.2g} times as dense.",
            "Give a unit of the same make.",
            code="rest-markers-density",
        )
    shrunk = (own - own.mean(axis=0)) / scale + other.mean(axis=0)
    found = MarkerMatcher(start.layout, seen.eye.shape).find(shrunk)
    if not found.accepted:
        raise PalpateError(
            f"The dots at rest are not those of {start.name}: {found.fault} ({found.agreement:.0%} agree).",
            "Give a unit of the same make, its camera turned by less than half the angle between two dots.",
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
    matrix = carried.reshape(2 * len(own), 2 * len(other))
    arrays = {**start.network.arrays, "projection": matrix @ start.network.arrays["projection"]}
    order = [start.outputs.index(name) for name in wanted]
    last = max(int(key[7:]) for key in arrays if key.startswith("weight_"))
    arrays[f"weight_{last}"] = arrays[f"weight_{last}"][:, :, order]
    arrays[f"bias_{last}"] = arrays[f"bias_{last}"][:, order]
    arrays["mean"], arrays["sd"] = arrays["mean"][order], arrays["sd"][order]
    return MarkerNetwork("carried", arrays)


def fine_tune_members(
    start: PretrainedModel, seen: PreparedRecording, progress: Progress
) -> dict[str, MarkerNetwork]:
    """The other network, corrected and adapted to this recording, by name.

    Raises
    ------
    PalpateError
        If its dots are not this unit's, or this recording has none.
    """
    if seen.assigned is None:
        raise PalpateError(
            "The recording has no numbered dots to adapt by.",
            "Learn without --from.",
            code="recording-markers-unassigned",
        )
    carried = transfer_network(start, seen)
    lesson, _ = seen.samples(markers=True)
    found = {CORRECTED: _correct(carried, lesson), ADAPTED: _adapt(carried, lesson)}
    for name, part in found.items():
        error = lesson.error(part.predict(seen.moved[lesson.validation]))
        progress.note(f"{name}: validation error {error:.4f} of the deviation")
    return found


def _correct(carried: MarkerNetwork, lesson: TrainingSet) -> MarkerNetwork:
    """The network with outputs a + B y: least squares on the lesson, held near B = 1."""
    given = carried.predict(lesson.inputs[lesson.train])
    scale = lesson.scale[1]
    residual = (lesson.targets[lesson.train] - given) / scale
    [(change, shift)] = solve_ridge(given / scale, residual, [_HOLD * len(given) ** 0.5])
    turn = np.eye(len(scale)) + change
    arrays = dict(carried.arrays)
    last = max(int(key[7:]) for key in arrays if key.startswith("weight_"))
    # y = z sd + mean becomes ((z sd + mean) / scale · turn + shift) scale
    factor = (arrays["sd"][:, None] / scale[:, None]) * turn * scale / arrays["sd"]
    arrays[f"weight_{last}"] = arrays[f"weight_{last}"] @ factor
    arrays[f"bias_{last}"] = arrays[f"bias_{last}"] @ factor
    arrays["mean"] = (arrays["mean"] / scale) @ turn * scale + shift * scale
    return MarkerNetwork(CORRECTED, arrays)


def _adapt(carried: MarkerNetwork, lesson: TrainingSet) -> MarkerNetwork:
    return _correct(carried, lesson).fine_tune(ADAPTED, lesson)


def compute_fine_tuning_curve(start: PretrainedModel, seen: PreparedRecording) -> tuple[CurvePoint, ...]:
    """Errors of the other network as it is and adapted with ever more presses, on the test presses."""
    if seen.assigned is None:
        return ()
    carried = transfer_network(start, seen)
    samples, test = seen.samples(markers=True)
    errors: FloatArray = carried.predict(seen.moved[test]) - seen.targets[test]
    first = CurvePoint(0, f"{start.name} as it is", tuple(float(x) for x in np.sqrt(np.mean(errors**2, axis=0))))
    adapted = compute_learning_curve(samples, seen.press, test, lambda some, _: [_adapt(carried, some)])
    return (first, *(replace(point, estimator="adapted") for point in adapted))
