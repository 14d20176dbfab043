"""Every round of a case is measured between two yardsticks, in CPU-seconds."""

import time
from collections.abc import Callable
from typing import Any

import pytest
from yardstick import Yardstick

MEASURED_S, LEAST, MOST = 4.0, 3, 12
"""CPU-seconds over which a case is measured, and least and most rounds: the shorter, the more it is disturbed."""


@pytest.fixture(scope="session")
def yardstick() -> Yardstick:
    rod = Yardstick()
    rod()
    return rod


@pytest.fixture
def measure(benchmark: Any, yardstick: Yardstick) -> Callable[..., Any]:
    """Run a case: once to warm up, then between yardsticks; keep what it counts."""

    def run(case: Callable[[], Any], counted: Callable[[Any], dict[str, int]]) -> Any:
        start = time.process_time()
        case()  # to compile and to fill caches
        rounds = min(max(round(MEASURED_S / (time.process_time() - start)), LEAST), MOST)
        rods: list[float] = []
        result = benchmark.pedantic(case, setup=lambda: rods.append(yardstick()), rounds=rounds)
        rods.append(yardstick())
        if benchmark.stats is not None:  # not where pytest-benchmark is switched off
            benchmark.extra_info |= {"rounds": list(benchmark.stats.stats.data), "yardsticks": rods} | counted(result)
        return result

    return run
