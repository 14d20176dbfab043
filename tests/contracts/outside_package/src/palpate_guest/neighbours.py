"""Mean pose of the nearest training displacements."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

from palpate.learn import EnsembleMember, TrainingRun, TrainingSet


class Neighbours(EnsembleMember):
    """Nearest neighbours of displacements of markers."""

    kind = "neighbours"
    reads_markers = True
    effort: ClassVar[Literal["ridge", "fast", "all"]] = "ridge"

    @classmethod
    def train(cls, name: str, samples: TrainingSet, run: TrainingRun) -> Self:
        return cls(name, {"moved": samples.inputs[samples.train], "poses": samples.targets[samples.train]})

    def predict(self, inputs: NDArray[Any]) -> NDArray[np.float64]:
        known = self.arrays["moved"].reshape(len(self.arrays["moved"]), -1)
        apart = np.linalg.norm(inputs.reshape(len(inputs), 1, -1) - known, axis=2)
        return np.asarray(self.arrays["poses"][np.argsort(apart, axis=1)[:, :4]].mean(axis=1))
