"""One thread a process, as in the workers of a study, and one hash of the source for all workers."""

import os
import sys

import pytest

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
# hundreds of processes of the tests import the package: each would compile it if none may keep what it compiled
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


@pytest.hookimpl(optionalhook=True)  # without pytest-xdist there are no workers
def pytest_xdist_auto_num_workers() -> int:
    """One worker more than processors, because tests of pages and of other processes mostly wait; five at most."""
    return min(4, os.cpu_count() or 1) + 1


def pytest_configure() -> None:
    from source_stamp import source_stamp

    source_stamp("")  # before workers start: they inherit it
