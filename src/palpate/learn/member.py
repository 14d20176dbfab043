"""Parts of a model: each is one estimator that was trained, and predicts from dots or from pictures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, load_extra, load_opencv
from palpate.learn.image_graph import graph_of
from palpate.learn.perceptron import evaluate_perceptrons


@dataclass(frozen=True, eq=False)
class EnsembleMember(ABC):
    """One trained estimator.

    Attributes
    ----------
    kind
        Word by which a file knows the class.
    name
        Such as ``dots-network``.
    arrays
        All its numbers, by name.
    """

    kind: ClassVar[str] = ""
    name: str
    arrays: dict[str, NDArray[Any]]

    @property
    @abstractmethod
    def reads_markers(self) -> bool:
        """Whether it reads displacements of dots, (n, m, 2) px; else pictures, (n, h, w) of 8 bit."""

    @abstractmethod
    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        """Poses (n, k) of dots or pictures (n, ...)."""


@final
class RidgeMember(EnsembleMember):
    """Ridge regression on displacements, or on pictures shrunk to `side` px."""

    kind = "linear"

    @property
    def reads_markers(self) -> bool:
        return "side" not in self.arrays

    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        side = None if self.reads_markers else int(self.arrays["side"])
        features = flat_features(inputs, side)
        return np.asarray(features @ self.arrays["weight"] + self.arrays["bias"], float)


@final
class MarkerNetwork(EnsembleMember):
    """Perceptrons on principal components of displacements, averaged."""

    kind = "dots-network"

    @property
    def reads_markers(self) -> bool:
        return True

    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        found = self.arrays
        features = flat_features(inputs, None) @ found["projection"] - found["offset"]
        layers = range(sum(name.startswith("weight_") for name in found))
        weights, biases = ([found[f"{kind}_{number}"] for number in layers] for kind in ("weight", "bias"))
        outputs = evaluate_perceptrons(features, weights, biases, "relu" if "relu" in found else "silu")
        return np.asarray(outputs.mean(axis=0) * found["sd"] + found["mean"], float)


@final
class ImageNetwork(EnsembleMember):
    """A convolutional network on pictures; of its outputs only those that are asked for are handed on."""

    kind = "picture-network"

    @property
    def reads_markers(self) -> bool:
        return False

    @cached_property
    def _session(self) -> Any:
        onnxruntime = load_extra("onnxruntime", "predict")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4
        return onnxruntime.InferenceSession(graph_of(self.arrays), options, ["CPUExecutionProvider"])

    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        session, parts = self._session, []
        for start in range(0, len(inputs), 64):
            batch = inputs[start : start + 64, None].astype(np.float32) / np.float32(255)
            parts.append(session.run(None, {"picture": batch})[0])
        found = np.concatenate(parts) if parts else np.zeros((0, len(self.arrays["mean"])))
        count = int(self.arrays["asked"])
        return np.asarray(found * self.arrays["sd"] + self.arrays["mean"], float)[:, :count]


PARTS = {part.kind: part for part in (RidgeMember, MarkerNetwork, ImageNetwork)}
"""Classes by their word."""


def flat_features(inputs: NDArray[Any], side: int | None) -> NDArray[np.float32]:
    """Inputs as rows (n, p): displacements as they are, pictures shrunk so that the longer side has `side` px."""
    if side is None:
        return np.asarray(inputs, np.float32).reshape(len(inputs), -1)
    cv2 = load_opencv()
    height, width = (max(1, round(length * side / max(inputs.shape[1:]))) for length in inputs.shape[1:])
    small = [cv2.resize(one, (width, height), interpolation=cv2.INTER_AREA) for one in inputs]
    return np.asarray(small, np.float32).reshape(len(inputs), -1) / np.float32(255)
