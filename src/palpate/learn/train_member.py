"""Training of networks on dots and on pictures, from nothing or from another network."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, child_seed, load_opencv
from palpate.core.run import Progress
from palpate.learn.components import find_components
from palpate.learn.member import ImageNetwork, MarkerNetwork, flat_features
from palpate.learn.rotation import COUNT, RotationOperators, pattern_order, rotation
from palpate.learn.trainer import Trainer, TrainerSpec, load_torch
from palpate.learn.training_set import TrainingSet

COMPONENTS, WIDTH, LAYERS, MEMBERS, DOTS_EPOCHS = 48, 256, 4, 3, 300
"""Network on dots: principal components read, units and number of hidden layers, members, epochs."""
CHANNELS, DENSE = (16, 32, 64, 96, 128), 256
"""Network on pictures: channels of its convolutions, units of its dense layer."""
NOISE, SHIFT, RISE = 0.1, 0.024, 0.25
"""While training on pictures: noise over their standard deviation, greatest shift over their longer side, share of
the training in which the rate rises. Shift and rise take a fifth off the error after as many epochs."""
_POWER = 0.35
"""Components are scaled by their deviation to this power: small ones count, but not as much as large ones."""
_TURNED, _FROM, _UNTIL = 0.8, 0.5, 0.85
"""Share of the batches that are turned, and shares of the training between which it falls to none: a built sensor is
not quite alike in all directions, and Euler angles do not quite turn."""


def train_marker_network(
    name: str,
    lesson: TrainingSet,
    course: TrainerSpec | None = None,
    members: int = MEMBERS,
    checkpoint: Path | None = None,
) -> MarkerNetwork:
    """Perceptrons on principal components of displacements.

    Parameters
    ----------
    name, lesson
        Name of the part, and what it learns from.
    course, members
        How it is trained, and how many are averaged.
    checkpoint
        File that holds what is known now and then.

    Raises
    ------
    MissingExtraError
        If torch is not installed.
    """
    taught = flat_features(lesson.inputs, None)[lesson.train]
    start = _components(taught.mean(axis=0), np.cov(taught.T), len(taught))
    return fine_tune_marker_network(
        name, lesson, start, course or TrainerSpec(DOTS_EPOCHS, noise=0.01), members=members, checkpoint=checkpoint
    )


def _components(mean: FloatArray, covariance: FloatArray, fitted: int) -> dict[str, NDArray[Any]]:
    """Projection (p, c) on principal components, each scaled, and where the mean (p,) lies there."""
    count = min(COMPONENTS, max(4, fitted // 4))

    def deviation(variance: FloatArray) -> FloatArray:
        variance = np.maximum(variance, 1e-9)
        return np.asarray(variance**_POWER * variance[0] ** (0.5 - _POWER))

    found = find_components(mean, covariance, count, deviation)
    return {"projection": found.projection, "offset": found.mean @ found.projection}


def train_rotated_network(
    name: str, lesson: TrainingSet, checkpoint: Path | None = None, epochs: int = DOTS_EPOCHS
) -> MarkerNetwork:
    """Perceptrons as `train_marker_network`, taught by turned presses as well; the lesson says how they turn."""
    assert lesson.rotation is not None
    torch = load_torch()
    base = lesson.rotation.base_px
    turns, fields = RotationOperators(lesson.rotation.places_px), flat_features(lesson.inputs - base, None)
    centre, covariance = turns.spread(fields[lesson.train].astype(float))
    start = _components(centre, covariance, int(lesson.train.sum()))
    along = [torch.as_tensor((turns.operator(k).T @ start["projection"]).astype(np.float32)) for k in range(COUNT)]
    flat, offset = torch.as_tensor(fields), torch.as_tensor(start["offset"].astype(np.float32))

    start["offset"] = start["offset"] + base.reshape(-1) @ start["projection"]

    def turned(rows: Any, number: int) -> Any:
        return flat[rows] @ along[number] - offset

    course = TrainerSpec(epochs, noise=0.01, augment=_vary(torch, lesson, turned, COUNT))
    return fine_tune_marker_network(name, lesson, start, course, checkpoint=checkpoint)


def _vary(torch: Any, lesson: TrainingSet, turned: Callable[[Any, int], Any], count: int) -> Any:
    """Draws batches, most of them turned by one of `count` steps around; `turned` gives inputs of rows so turned."""
    assert lesson.rotation is not None
    mean, sd = lesson.scale
    targets = torch.as_tensor(((lesson.targets - mean) / sd).astype(np.float32))
    steps = [lesson.rotation.sense * number * (COUNT // count) for number in range(count)]
    tilts = [torch.as_tensor(rotation(step).T.astype(np.float32)) for step in steps]

    def vary(rows: Any, over: float, random: Any) -> tuple[Any, Any]:
        share = _TURNED * min(1.0, max(0.0, (_UNTIL - over) / (_UNTIL - _FROM)))
        chance = float(torch.rand(1, generator=random))
        number = int(torch.randint(count, (1,), generator=random)) if chance < share else 0
        given = targets[rows]
        return turned(rows, number), torch.cat([given[:, :2] @ tilts[number], given[:, 2:]], dim=1)

    return vary


def fine_tune_marker_network(
    name: str,
    lesson: TrainingSet,
    start: Mapping[str, NDArray[Any]],
    course: TrainerSpec,
    *,
    members: int = MEMBERS,
    checkpoint: Path | None = None,
) -> MarkerNetwork:
    """Train perceptrons on a given projection of displacements, from given weights where there are such."""
    torch = load_torch()
    given = "weight_0" in start
    mean, sd = (start["mean"], start["sd"]) if given else lesson.scale
    features = flat_features(lesson.inputs, None) @ start["projection"] - start["offset"]
    inputs = torch.as_tensor(features.astype(np.float32))
    targets = torch.as_tensor(((lesson.targets - mean) / sd).astype(np.float32))
    states = []
    for member in range(len(start["weight_0"]) if given else members):
        random = torch.Generator().manual_seed(child_seed(lesson.seed, name, member))
        net = _build_perceptron(torch, start, member) if given else _new_perceptron(torch, inputs, targets, random)
        own = None if checkpoint is None else checkpoint.with_suffix(f".{member}")
        states.append(Trainer(net, lesson, inputs, targets, course, random).run(own))
    arrays = {key: np.asarray(start[key]) for key in ("projection", "offset")} | {"mean": mean, "sd": sd}
    for layer, key in enumerate(key for key in states[0] if key.endswith(".weight")):
        arrays[f"weight_{layer}"] = np.stack([state[key].numpy().T for state in states])
        arrays[f"bias_{layer}"] = np.stack([state[key.replace("weight", "bias")].numpy() for state in states])
    return MarkerNetwork(name, arrays | ({"relu": np.array(1)} if "relu" in start else {}))


def _new_perceptron(torch: Any, inputs: Any, targets: Any, random: Any) -> Any:
    layers, inward = [], inputs.shape[1]
    for _ in range(LAYERS):
        layers += [_layer(torch, random, torch.nn.Linear, inward, WIDTH), torch.nn.SiLU()]
        inward = WIDTH
    return torch.nn.Sequential(*layers, _layer(torch, random, torch.nn.Linear, inward, targets.shape[1]))


def _layer(torch: Any, random: Any, kind: Any, *sizes: Any, **words: Any) -> Any:
    """A layer whose weights are drawn as torch draws them, but from a generator: evenly within 1/√inputs."""
    layer = torch.nn.utils.skip_init(kind, *sizes, **words)
    bound = layer.weight[0].numel() ** -0.5
    with torch.no_grad():
        for values in (layer.weight, *([] if layer.bias is None else [layer.bias])):
            values.uniform_(-bound, bound, generator=random)
    return layer


def _build_perceptron(torch: Any, arrays: Mapping[str, NDArray[Any]], member: int) -> Any:
    """A perceptron with the weights of one member."""
    layers: list[Any] = []
    for number in range(sum(key.startswith("weight_") for key in arrays)):
        weight, bias = arrays[f"weight_{number}"][member], arrays[f"bias_{number}"][member]
        layer = torch.nn.utils.skip_init(torch.nn.Linear, *weight.shape)
        layer.weight.data = torch.as_tensor(np.ascontiguousarray(weight.T, np.float32))
        layer.bias.data = torch.as_tensor(np.ascontiguousarray(bias, np.float32))
        layers += [layer, torch.nn.ReLU() if "relu" in arrays else torch.nn.SiLU()]
    return torch.nn.Sequential(*layers[:-1])


def train_image_network(
    name: str, lesson: TrainingSet, asked: int, course: TrainerSpec, checkpoint: Path, progress: Progress
) -> ImageNetwork:
    """A convolutional network on pictures.

    Parameters
    ----------
    name, lesson
        Name of the part, and what it learns from: of its targets the first `asked` are handed on.
    asked, course
        Number of targets handed on; epochs and threads.
    checkpoint
        File that holds what is known after each epoch; it is removed by who keeps the part.
    progress
        Receives each epoch.

    Raises
    ------
    MissingExtraError
        If torch is not installed.
    """
    torch = load_torch()
    mean, sd = lesson.scale
    random = torch.Generator().manual_seed(child_seed(lesson.seed, name))
    net = _build_network(torch, lesson.inputs.shape[1:], lesson.targets.shape[1], random)
    taught = lesson.inputs[lesson.train]
    level, spread = float(taught.mean()) / 255.0, max(float(taught.std()) / 255.0, 1e-3)
    pictures = torch.as_tensor(lesson.inputs)[:, None]
    targets = torch.as_tensor(((lesson.targets - mean) / sd).astype(np.float32))
    shift = round(SHIFT * max(lesson.inputs.shape[1:]))
    spec = replace(course, noise=NOISE, grey=(level, spread), shift=shift, warm_up_share=RISE)
    if lesson.rotation is not None:
        order = pattern_order(lesson.rotation.places_px)
        turned = partial(
            _turn_pictures, torch, lesson.inputs, RotationOperators(lesson.rotation.places_px).middle, order
        )
        spec = replace(spec, augment=_vary(torch, lesson, turned, order))
    state = Trainer(net, lesson, pictures, targets, spec, random).run(checkpoint, progress, name)
    arrays = _folded(state, level, spread)
    return ImageNetwork(name, arrays | {"mean": mean, "sd": sd, "asked": np.array(asked)})


def _turn_pictures(torch: Any, pictures: NDArray[Any], middle: FloatArray, order: int, rows: Any, number: int) -> Any:
    """Pictures (b, 1, h, w) of rows, turned about a point (2,) px by so many of `order` steps around."""
    asked = pictures[rows.numpy()]
    if number:
        size, turn = pictures.shape[1:], np.column_stack([rotation(number * (COUNT // order)), np.zeros(2)])
        turn[:, 2] = middle - turn[:, :2] @ middle
        cv2 = load_opencv()
        asked = np.stack([cv2.warpAffine(one, turn, size[::-1], borderMode=cv2.BORDER_REPLICATE) for one in asked])
    return torch.as_tensor(asked)[:, None]


def _build_network(torch: Any, size: tuple[int, ...], outputs: int, random: Any) -> Any:
    layers, inward, side = [], 1, np.array(size)
    for number, outward in enumerate(CHANNELS):
        width, stride = (5, 2) if number == 0 else (3, 1)
        layers += [
            _layer(torch, random, torch.nn.Conv2d, inward, outward, width, stride, width // 2, bias=False),
            torch.nn.BatchNorm2d(outward),
            torch.nn.ReLU(),
        ]
        layers += [] if number == 0 else [torch.nn.AvgPool2d(2)]
        side = (side + 1) // 2 if number == 0 else side // 2
        inward = outward
        if min(side) < 8:
            break
    return torch.nn.Sequential(
        torch.nn.Sequential(*layers),
        torch.nn.Flatten(),
        _layer(torch, random, torch.nn.Linear, inward * int(side.prod()), DENSE),
        torch.nn.ReLU(),
        _layer(torch, random, torch.nn.Linear, DENSE, outputs),
    )


def _folded(state: dict[str, Any], level: float, spread: float) -> dict[str, NDArray[Any]]:
    """Arrays of a network with the normalisation of pictures and batches folded into its convolutions."""
    arrays: dict[str, NDArray[Any]] = {}
    numbers = sorted(
        {int(key.split(".")[1]) for key in state if key.startswith("0.") and key.endswith("running_mean")}
    )
    for layer, place in enumerate(numbers):
        own = {
            key: state[f"0.{place}.{key}"].numpy().astype(float)
            for key in ("weight", "bias", "running_mean", "running_var")
        }
        factor = own["weight"] / np.sqrt(own["running_var"] + 1e-5)
        kernel = state[f"0.{place - 1}.weight"].numpy().astype(float)
        arrays[f"kernel_{layer}"] = kernel * factor[:, None, None, None]
        arrays[f"shift_{layer}"] = own["bias"] - own["running_mean"] * factor
    arrays["level"], arrays["spread"] = np.array(level), np.array(spread)
    arrays["dense_0"], arrays["add_0"] = state["2.weight"].numpy(), state["2.bias"].numpy()
    arrays["dense_1"], arrays["add_1"] = state["4.weight"].numpy(), state["4.bias"].numpy()
    arrays["averages"] = np.array(1)  # older ones pool by the maximum, which forgets where in four px a dot is
    return arrays
