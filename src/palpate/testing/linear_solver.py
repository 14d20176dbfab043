"""Contract suite of sparse direct solvers."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse

from palpate.core import FloatArray
from palpate.mechanics import LinearSolver, Pattern, SingularMatrixError


class LinearSolverSuite:
    """Inherit and give the fixture `solver`; pytest collects the rest."""

    @pytest.fixture
    def solver(self) -> LinearSolver:
        """A solver that has analysed nothing yet."""
        raise NotImplementedError("Give the fixture `solver`.")

    @pytest.mark.parametrize("negative", [0, 3])
    def test_it_solves_and_counts_the_negative_pivots(self, solver: LinearSolver, negative: int) -> None:
        matrix = _matrix(300, negative)
        pattern, data = _pattern_of(matrix)
        solver.analyze(pattern)
        right = np.random.default_rng(1).normal(size=300)
        assert solver.refactor(data) in (negative, -1)
        assert matrix @ solver.solve(right) == pytest.approx(right, abs=1e-8)

    def test_new_values_of_a_pattern_replace_the_old(self, solver: LinearSolver) -> None:
        matrix = _matrix(300, 2)
        pattern, data = _pattern_of(matrix)
        solver.analyze(pattern)
        solver.refactor(data)
        solver.refactor(2 * data)
        right = np.random.default_rng(1).normal(size=300)
        assert 2 * (matrix @ solver.solve(right)) == pytest.approx(right, abs=1e-8)

    def test_values_of_a_pattern_may_vanish(self, solver: LinearSolver) -> None:
        matrix = _matrix(300, 2)
        pattern, data = _pattern_of(matrix)
        solver.analyze(pattern)
        solver.refactor(data)
        diagonal = np.zeros(len(data), dtype=bool)
        diagonal[pattern.start[:-1]] = True
        solver.refactor(np.where(diagonal, data, 0.0))
        right = np.random.default_rng(1).normal(size=300)
        assert data[diagonal] * solver.solve(right) == pytest.approx(right, abs=1e-8)

    def test_another_pattern_may_follow(self, solver: LinearSolver) -> None:
        for size in (40, 90):
            matrix = _matrix(size, 1)
            pattern, data = _pattern_of(matrix)
            solver.analyze(pattern)
            solver.refactor(data)
            assert matrix @ solver.solve(np.ones(size)) == pytest.approx(np.ones(size), abs=1e-8)

    def test_neither_values_nor_right_hand_side_are_changed(self, solver: LinearSolver) -> None:
        pattern, data = _pattern_of(_matrix(50, 0))
        right, values = np.ones(50), data.copy()
        solver.analyze(pattern)
        solver.refactor(data)
        solver.solve(right)
        assert np.array_equal(data, values)
        assert np.array_equal(right, np.ones(50))

    def test_values_that_are_not_finite_are_refused(self, solver: LinearSolver) -> None:
        pattern, data = _pattern_of(_matrix(50, 0))
        solver.analyze(pattern)
        data[3] = np.nan
        with pytest.raises(SingularMatrixError, match="finite"):
            solver.refactor(data)


def _matrix(size: int, negative: int) -> sparse.csr_matrix:
    """Symmetric sparse matrix with a known number of negative eigenvalues (Sylvester's law of inertia)."""
    rng = np.random.default_rng(0)
    below = sparse.random(size, size, density=0.02, random_state=rng, format="csr")
    lower = sparse.tril(below, -1) + sparse.eye(size)
    signs = np.ones(size)
    signs[:negative] = -1
    return sparse.csr_matrix(lower @ sparse.diags(signs * rng.uniform(1, 2, size)) @ lower.T)


def _pattern_of(matrix: sparse.csr_matrix) -> tuple[Pattern, FloatArray]:
    upper = sparse.triu(matrix, format="csr")
    upper.sort_indices()
    return Pattern(upper.indptr.astype(np.int64), upper.indices.astype(np.int64)), upper.data
