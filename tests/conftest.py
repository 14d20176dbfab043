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


@pytest.hookimpl(trylast=True)  # after the tests of the other tier are left out
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Deal the longest tests (`slow(seconds)`) to the workers first, so that none of them runs alone at the end.

    pytest-xdist gives each worker an equal share of the tests, in their order.
    """
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    seconds = {item: float(mark.args[0]) for item in items if (mark := item.get_closest_marker("slow")) and mark.args}
    longest, others = sorted(seconds, key=lambda item: -seconds[item]), [one for one in items if one not in seconds]
    if workers == 1 or not longest:
        return
    dealt: list[pytest.Item] = []
    for worker in range(workers):
        share = (len(items) - len(dealt)) // (workers - worker)
        own = longest[worker::workers]
        rest = max(share - len(own), 0)
        dealt += [*own, *others[:rest]]
        others = others[rest:]
    items[:] = [*dealt, *others]


def pytest_configure() -> None:
    from source_stamp import source_stamp

    source_stamp("")  # before workers start: they inherit it
