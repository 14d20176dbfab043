"""Training of networks on displacements of markers and on images."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray

from palpate.core import FloatArray, child_seed, load_opencv
from palpate.learn.components import find_components
from palpate.learn.gaussian_process import STEPS
from palpate.learn.network import PerceptronTask, collect_layers
from palpate.learn.rotation import COUNT, RotationOperators, pattern_order
from palpate.learn.trainer import TrainedState, Trainer, TrainerSpec, TrainingTask, add_noise, fall
from palpate.learn.training_set import TrainingSet, flat_features

if TYPE_CHECKING:
    from torch import Generator, Tensor

COMPONENTS, WIDTH, LAYERS, MEMBERS, MARKER_EPOCHS = 48, 256, 4, 3, 300
"""Network on markers: principal components read, units and number of hidden layers, members, epochs.
By hand."""
CHANNELS, DENSE = (16, 32, 64, 96, 128), 256
"""Network on images: channels of its convolutions, units of its dense layer. By hand."""
MARKER_NOISE, NOISE, SHIFT, RISE = 0.01, 0.1, 0.024, 0.25
"""Noise, shift and warm-up of a training.

Noise of scaled components; on images noise over their standard deviation, maximum shift over their longer side, and
share of the training in which the rate increases. Shift and increase reduce the error by a fifth after as many
epochs.
"""
_FINE_TUNING = TrainerSpec(epochs=120, batch=16, learning_rate=3e-4, weight_decay=0.0, anchor_weight=1e-3)
_POWER = 0.35
"""Power of the deviation by which components are scaled: small ones count, but less than large ones.
By hand."""
_TURNED, _FROM, _UNTIL = 0.8, 0.5, 0.85
"""Share of rotated batches, and shares of the training between which it falls to zero.

A built sensor is not quite symmetric, and Euler angles do not rotate exactly. By hand.
"""

Source = Callable[["Tensor", float, "Sequence[Generator]"], "tuple[Tensor, Tensor]"]
"""Gives inputs (r, b, …) and targets (r, b, k) of samples (r, b), see `TrainingTask.draw`."""


def _plain(inputs: Tensor, targets: Tensor) -> Source:
    return lambda rows, done, random: (inputs[rows], targets[rows])


def _rotated(samples: TrainingSet, turned: Callable[[Tensor, int], Tensor], count: int) -> Source:
    """Batches, most of them rotated by one of `count` steps around by `turned`."""
    assert samples.rotation is not None
    turns, (mean, sd) = samples.rotation.turns(count), samples.scale
    given = [(samples.rotation.turn_targets(samples.targets, turn) - mean) / sd for turn in turns]
    targets = [torch.as_tensor(each.astype(np.float32)) for each in given]

    def draw(rows: Tensor, done: float, random: Sequence[Generator]) -> tuple[Tensor, Tensor]:
        share = _TURNED * min(1.0, max(0.0, (_UNTIL - done) / (_UNTIL - _FROM)))
        drawn = []
        for own, stream in zip(rows, random, strict=True):
            rotates = float(torch.rand(1, generator=stream)) < share
            number = int(torch.randint(len(turns), (1,), generator=stream)) if rotates else 0
            drawn.append((turned(own, number), targets[number][own]))
        inputs, outputs = zip(*drawn, strict=True)
        return torch.stack(inputs), torch.stack(outputs)

    return draw


class _MarkerTask(PerceptronTask):
    """Perceptrons on principal components of displacements."""

    def __init__(
        self, samples: TrainingSet, features: FloatArray, targets: FloatArray, source: Source | None = None
    ) -> None:
        self.inputs = torch.as_tensor(features.astype(np.float32))
        self.targets = torch.as_tensor(targets.astype(np.float32))
        self.rows = torch.as_tensor(np.flatnonzero(samples.train))
        self.held = torch.as_tensor(np.flatnonzero(samples.validation))
        self.activation, self.source = "silu", source or _plain(self.inputs, self.targets)

    def draw_weights(self, random: Sequence[Generator]) -> None:
        """Start from weights drawn evenly within 1 / √inputs, as those of `torch.nn.Linear`."""
        sizes = [self.inputs.shape[1], *[WIDTH] * LAYERS, self.targets.shape[1]]
        self.parameters = []
        for inward, outward in pairwise(sizes):
            weight, bias = torch.empty(len(random), outward, inward), torch.empty(len(random), 1, outward)
            for values, own, stream in zip(weight, bias, random, strict=True):
                for drawn in (values, own):
                    drawn.uniform_(-(inward**-0.5), inward**-0.5, generator=stream)
            self.parameters += [weight.transpose(1, 2).contiguous().requires_grad_(), bias.requires_grad_()]

    def draw(self, rows: Tensor, done: float, random: Sequence[Generator]) -> tuple[Tensor, Tensor]:
        inputs, targets = self.source(rows, done, random)
        return add_noise(inputs, MARKER_NOISE, random), targets

    def validation(self) -> Iterable[tuple[Tensor, Tensor]]:
        return [(self.inputs[self.held][None], self.targets[self.held])]


def train_marker_network(
    name: str,
    samples: TrainingSet,
    *,
    epochs: int = MARKER_EPOCHS,
    members: int = MEMBERS,
    checkpoint: Path | None = None,
) -> dict[str, NDArray[Any]]:
    """Train perceptrons on principal components of displacements, also of rotated ones.

    Parameters
    ----------
    name, samples
        Name of the estimator, which decides its random streams, and its samples.
    epochs, members
        Passes over the samples, and networks that are averaged.
    checkpoint
        File of the state of an interrupted training.
    """
    fields, turning, source = flat_features(samples.inputs, None), samples.rotation, None
    if turning is None:
        start = _find_inputs(fields[samples.train].mean(axis=0), np.cov(fields[samples.train].T), samples)
    else:
        operators = RotationOperators(turning.places_px)
        relative = flat_features(samples.inputs - turning.base_px, None)
        start = _find_inputs(*operators.spread(relative[samples.train].astype(float), turning.turns(STEPS)), samples)
        along = [
            torch.as_tensor((operators.operator(turn).T @ start["projection"]).astype(np.float32))
            for turn in turning.turns(COUNT)
        ]
        flat, offset = torch.as_tensor(relative), torch.as_tensor(start["offset"].astype(np.float32))
        source = _rotated(samples, lambda rows, number: flat[rows] @ along[number] - offset, COUNT)
        start["offset"] = start["offset"] + turning.base_px.reshape(-1) @ start["projection"]
    random = [torch.Generator().manual_seed(child_seed(samples.seed, name, member)) for member in range(members)]
    task = _MarkerTask(samples, fields @ start["projection"] - start["offset"], samples.standardised, source)
    task.draw_weights(random)
    mean, sd = samples.scale
    found = Trainer(task, TrainerSpec(epochs), random).run(checkpoint)
    return start | {"mean": mean, "sd": sd} | _layer_arrays(found)


def fine_tune_marker_network(
    name: str, samples: TrainingSet, start: Mapping[str, NDArray[Any]]
) -> dict[str, NDArray[Any]]:
    """Train perceptrons from the arrays of others, slowly and tied to their weights."""
    features = flat_features(samples.inputs, None) @ start["projection"] - start["offset"]
    task = _MarkerTask(samples, features, (samples.targets - start["mean"]) / start["sd"])
    task.activation, task.parameters = "relu" if "relu" in start else "silu", []
    for number in range(sum(key.startswith("weight_") for key in start)):
        for values in (start[f"weight_{number}"], start[f"bias_{number}"][:, None]):
            task.parameters.append(torch.tensor(np.asarray(values, np.float32), requires_grad=True))
    random = [
        torch.Generator().manual_seed(child_seed(samples.seed, name, member))
        for member in range(len(start["weight_0"]))
    ]
    return dict(start) | _layer_arrays(Trainer(task, _FINE_TUNING, random).run())


def _layer_arrays(members: Sequence[TrainedState]) -> dict[str, NDArray[Any]]:
    weights, biases = collect_layers(members)
    arrays = {f"weight_{number}": weight.astype(np.float32) for number, weight in enumerate(weights)}
    return arrays | {f"bias_{number}": bias.astype(np.float32) for number, bias in enumerate(biases)}


def _find_inputs(mean: FloatArray, covariance: FloatArray, samples: TrainingSet) -> dict[str, NDArray[Any]]:
    """Projection (p, c) on scaled principal components, and the mean (p,) there."""

    def deviation(variance: FloatArray) -> FloatArray:
        variance = np.maximum(variance, 1e-9)
        return np.asarray(variance**_POWER * variance[0] ** (0.5 - _POWER))

    found = find_components(mean, covariance, min(COMPONENTS, max(4, int(samples.train.sum()) // 4)), deviation)
    return {"projection": found.projection, "offset": found.mean @ found.projection}


class ImageTask(TrainingTask):
    """A convolutional network on images."""

    def __init__(self, name: str, samples: TrainingSet) -> None:
        self.random = [torch.Generator().manual_seed(child_seed(samples.seed, name))]
        self.net = _build_network(samples.inputs.shape[1:], samples.targets.shape[1], self.random[0])
        self.net.to(memory_format=torch.channels_last)
        self.names = [key for key, _ in self.net.named_parameters()]
        self.parameters = [value.detach()[None].requires_grad_() for value in self.net.parameters()]
        self.buffers = list(self.net.buffers())
        self.rows = torch.as_tensor(np.flatnonzero(samples.train))
        self.held = torch.as_tensor(np.flatnonzero(samples.validation))
        train = samples.inputs[samples.train]
        self.level, self.spread = float(train.mean()) / 255.0, max(float(train.std()) / 255.0, 1e-3)
        self.images = torch.as_tensor(samples.inputs)[:, None]
        self.targets = torch.as_tensor(samples.standardised.astype(np.float32))
        self.shift = round(SHIFT * max(samples.inputs.shape[1:]))
        # processors that multiply numbers of 16 bit train on images twice as fast with them
        self.short = bool(getattr(torch.cpu, "_is_avx512_bf16_supported", lambda: False)())
        self.source = _plain(self.images, self.targets)
        if samples.rotation is not None:
            # a reflected pattern of markers is another one, a rotated one is not
            rotation, middle = (
                samples.rotation._replace(frame_rad=None),
                RotationOperators(samples.rotation.places_px).middle,
            )
            order = pattern_order(rotation.places_px)
            turns = rotation.turns(order)
            self.source = _rotated(
                replace(samples, rotation=rotation),
                lambda rows, number: rotate_images(samples.inputs[rows.numpy()], middle, turns[number]),
                order,
            )

    def spec(self, epochs: int, threads: int) -> TrainerSpec:
        """Settings of the training."""

        def schedule(step: int, steps: int) -> float:
            rise = RISE * steps
            return step / rise if step < rise else fall((step - rise) / (steps - rise))

        return TrainerSpec(epochs, schedule=schedule, threads=threads)

    def _normalised(self, images: Tensor) -> Tensor:
        scaled = (images.float() / 255.0 - self.level) / self.spread
        return scaled.contiguous(memory_format=torch.channels_last)

    def draw(self, rows: Tensor, done: float, random: Sequence[Generator]) -> tuple[Tensor, Tensor]:
        images, targets = self.source(rows, done, random)
        inputs, most = self._normalised(images[0]), self.shift
        if most:
            height, width = inputs.shape[-2:]
            padded = torch.nn.functional.pad(inputs, (most,) * 4, value=-self.level / self.spread)
            down, right = torch.randint(0, 2 * most + 1, (2,), generator=random[0]).tolist()
            inputs = padded[..., down : down + height, right : right + width]
        return add_noise(inputs[None], NOISE, random), targets

    def forward(self, parameters: list[Tensor], inputs: Tensor, random: Sequence[Generator] | None) -> Tensor:
        self.net.train(random is not None)
        own = {key: value.squeeze(0) for key, value in zip(self.names, parameters, strict=True)}
        with torch.autocast("cpu", torch.bfloat16, enabled=self.short and random is not None):
            outputs: Tensor = torch.func.functional_call(self.net, own, (inputs[0],))
        return outputs.float()[None]

    def validation(self) -> Iterable[tuple[Tensor, Tensor]]:
        for rows in torch.split(self.held, 64):
            yield self._normalised(self.images[rows])[None], self.targets[rows]

    def fold(self, state: Sequence[Tensor]) -> dict[str, NDArray[Any]]:
        """Arrays of the network with the normalisation of images and batches folded into its convolutions."""
        names = [*self.names, *(key for key, _ in self.net.named_buffers())]
        found = {key: value.numpy() for key, value in zip(names, state, strict=True)}
        arrays: dict[str, NDArray[Any]] = {}
        places = sorted(int(key.split(".")[1]) for key in found if key.endswith("running_mean"))
        for layer, place in enumerate(places):
            own = {
                key: found[f"0.{place}.{key}"].astype(float)
                for key in ("weight", "bias", "running_mean", "running_var")
            }
            factor = own["weight"] / np.sqrt(own["running_var"] + 1e-5)
            kernel = found[f"0.{place - 1}.weight"].astype(float)
            arrays[f"kernel_{layer}"] = kernel * factor[:, None, None, None]
            arrays[f"shift_{layer}"] = own["bias"] - own["running_mean"] * factor
        arrays["level"], arrays["spread"] = np.array(self.level), np.array(self.spread)
        arrays["dense_0"], arrays["add_0"] = found["2.weight"], found["2.bias"]
        arrays["dense_1"], arrays["add_1"] = found["4.weight"], found["4.bias"]
        arrays["averages"] = np.array(1)  # older ones pool by the maximum, which forgets where in four px a marker is
        return arrays


def rotate_images(images: NDArray[Any], middle: FloatArray, turn: FloatArray) -> Tensor:
    """Images (b, 1, h, w) from (b, h, w), rotated by `turn` (2, 2) about a point (2,) px."""
    if not np.array_equal(turn, np.eye(2)):
        size, matrix = images.shape[1:], np.column_stack([turn, middle - turn @ middle])
        cv2 = load_opencv()
        images = np.stack(
            [cv2.warpAffine(one, matrix, size[::-1], borderMode=cv2.BORDER_REPLICATE) for one in images]
        )
    return torch.as_tensor(images)[:, None]


def _layer(random: Generator, kind: Any, *sizes: Any, **options: Any) -> Any:
    """A layer whose weights are drawn as torch draws them, but from a generator: evenly within 1/√inputs."""
    layer = kind(*sizes, device="meta", **options).to_empty(device="cpu")
    bound = layer.weight[0].numel() ** -0.5
    with torch.no_grad():
        for values in (layer.weight, *([] if layer.bias is None else [layer.bias])):
            values.uniform_(-bound, bound, generator=random)
    return layer


def _build_network(size: tuple[int, ...], outputs: int, random: Generator) -> Any:
    layers: list[torch.nn.Module] = []
    inward, side = 1, np.array(size)
    for number, outward in enumerate(CHANNELS):
        width, stride = (5, 2) if number == 0 else (3, 1)
        layers += [
            _layer(random, torch.nn.Conv2d, inward, outward, width, stride, width // 2, bias=False),
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
        _layer(random, torch.nn.Linear, inward * int(side.prod()), DENSE),
        torch.nn.ReLU(),
        _layer(random, torch.nn.Linear, DENSE, outputs),
    )
