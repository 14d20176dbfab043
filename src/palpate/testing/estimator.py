"""Requirements on every kind of estimator that is trained on recordings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from palpate.core.named_arrays import read_arrays, write_arrays
from palpate.learn import EFFORTS, ESTIMATORS, EnsembleMember, TrainingRun, TrainingSet


class EstimatorSuite:
    """Inherit and give the fixture `kind`; pytest collects the rest."""

    @pytest.fixture
    def kind(self) -> type[EnsembleMember]:
        """A class of the registry."""
        raise NotImplementedError("Give the fixture `kind`.")

    @pytest.fixture
    def samples(self, kind: type[EnsembleMember]) -> TrainingSet:
        """Displacements of nine markers, or images of a blob, with two targets and an auxiliary one."""
        random, rows = np.random.default_rng(0), np.arange(32)
        poses = random.uniform(-1.0, 1.0, (90, 3))
        inputs = np.tanh(poses @ random.normal(0.0, 1.0, (3, 18))).reshape(90, 9, 2)
        if not kind.reads_markers:
            column, row = (np.exp(-(((rows - 16 - 9 * poses[:, k, None]) / 3.0) ** 2)) for k in (0, 1))
            inputs = np.asarray(255 * row[:, :, None] * column[:, None, :], np.uint8)
        train = np.arange(90) < 70
        return TrainingSet(inputs, poses, train, ~train, seed=1, auxiliary=1 if kind.takes_auxiliary else 0)

    def test_it_is_found_by_its_name(self, kind: type[EnsembleMember]) -> None:
        assert ESTIMATORS.get(kind.kind) is kind
        assert kind.effort in EFFORTS

    def test_it_estimates_better_than_the_mean_also_from_its_file(
        self, kind: type[EnsembleMember], samples: TrainingSet, tmp_path: Path
    ) -> None:
        member = kind.train("trained", samples, TrainingRun(epochs=30))
        found = member.predict(samples.inputs[samples.validation])
        assert found.shape == (20, samples.n_outputs)
        error = (found - samples.targets[samples.validation, : samples.n_outputs])[:, :2]
        assert np.sqrt(np.mean(error**2)) < 0.7 * samples.targets[:, :2].std()
        write_arrays(tmp_path / "member.h5", member.arrays)
        again = kind("read", read_arrays(tmp_path / "member.h5")).predict(samples.inputs[samples.validation])
        assert again == pytest.approx(found, abs=1e-4)

    def test_the_same_seed_gives_the_same_numbers(self, kind: type[EnsembleMember], samples: TrainingSet) -> None:
        one, other = (kind.train("trained", samples, TrainingRun(epochs=2)).arrays for _ in range(2))
        assert one.keys() == other.keys()
        assert all(np.array_equal(one[name], other[name]) for name in one)
