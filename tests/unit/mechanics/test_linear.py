"""Sparse backends by name; what each of them must satisfy is in tests/contracts."""

import pytest

from palpate.core import PalpateError
from palpate.mechanics.linear import make_linear_solver


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(PalpateError, match="pardiso, rslab, superlu"):
        make_linear_solver("umfpack")
