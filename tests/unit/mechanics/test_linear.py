"""One suite for every sparse backend: same solution, same inertia, the same errors."""

import numpy as np
import pytest
import scipy.sparse as sparse

from palpate.core import PalpateError
from palpate.mechanics.linear import LinearSolver, Pattern, SingularMatrixError, make_linear_solver, solver_backends


def random_matrix(size: int, negative: int, seed: int = 0) -> sparse.csr_matrix:
    """Symmetric sparse matrix with a known number of negative eigenvalues (by Sylvester's law)."""
    rng = np.random.default_rng(seed)
    lower = sparse.random(size, size, density=0.02, random_state=rng, format="csr")
    lower = sparse.tril(lower, -1) + sparse.eye(size)
    signs = np.ones(size)
    signs[:negative] = -1
    return sparse.csr_matrix(lower @ sparse.diags(signs * rng.uniform(1, 2, size)) @ lower.T)


def pattern_of(matrix: sparse.csr_matrix) -> tuple[Pattern, np.ndarray]:
    upper = sparse.triu(matrix, format="csr")
    upper.sort_indices()
    return Pattern(upper.indptr.astype(np.int64), upper.indices.astype(np.int64)), upper.data


@pytest.fixture(params=[name for name, installed, _ in solver_backends() if installed])
def solver(request: pytest.FixtureRequest) -> LinearSolver:
    return make_linear_solver(request.param)


@pytest.mark.parametrize("negative", [0, 3])
def test_solution_and_inertia(solver: LinearSolver, negative: int) -> None:
    matrix = random_matrix(300, negative)
    pattern, data = pattern_of(matrix)
    solver.analyze(pattern)
    right = np.random.default_rng(1).normal(size=300)
    assert solver.refactor(data) in (negative, -1)
    assert matrix @ solver.solve(right) == pytest.approx(right, abs=1e-8)
    solver.refactor(2 * data)
    assert 2 * (matrix @ solver.solve(right)) == pytest.approx(right, abs=1e-8)


def test_values_that_are_not_finite_are_refused(solver: LinearSolver) -> None:
    pattern, data = pattern_of(random_matrix(50, 0))
    solver.analyze(pattern)
    data[3] = np.nan
    with pytest.raises(SingularMatrixError, match="finite"):
        solver.refactor(data)


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(PalpateError, match="pardiso, rslab, superlu"):
        make_linear_solver("umfpack")
