"""Every sparse solver that is installed, one row each."""

import pytest

from palpate.mechanics import LinearSolver, make_linear_solver, solver_backends
from palpate.testing import LinearSolverSuite


class TestLinearSolver(LinearSolverSuite):
    @pytest.fixture(params=[name for name, installed, _ in solver_backends() if installed])
    def solver(self, request: pytest.FixtureRequest) -> LinearSolver:
        return make_linear_solver(request.param)
