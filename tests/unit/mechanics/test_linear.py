"""Sparse backends by name; what each of them must satisfy is in tests/contracts."""

from errors import refused
from palpate.mechanics.linear import make_linear_solver


def test_an_unknown_backend_is_refused() -> None:
    with refused("solver-unknown", "pardiso", "rslab", "superlu"):
        make_linear_solver("umfpack")
