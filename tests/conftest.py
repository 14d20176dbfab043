"""One thread a process, as in the workers of a study, and one hash of the source for all workers."""

import os

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


def pytest_configure() -> None:
    from source_stamp import source_stamp

    source_stamp("")  # before workers start: they inherit it
