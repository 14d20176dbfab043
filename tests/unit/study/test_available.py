import math
from pathlib import Path

import pytest

from palpate.study import available


@pytest.fixture
def system(tmp_path: Path) -> Path:
    path = tmp_path / "meminfo"
    path.write_text("MemTotal:       24000000 kB\nMemAvailable:    8388608 kB\nHugePages_Total:       0\n")
    return path


def test_memory_is_that_of_the_machine_where_nothing_limits_it(system: Path, tmp_path: Path) -> None:
    assert available.available_memory(system, tmp_path / "none") == 8 * 2**30
    (tmp_path / "memory.max").write_text("max\n")
    (tmp_path / "memory.stat").write_text("anon 1000\n")
    assert available.available_memory(system, tmp_path) == 8 * 2**30


def test_the_limit_of_a_container_counts_less_what_it_holds(system: Path, tmp_path: Path) -> None:
    (tmp_path / "memory.max").write_text(f"{3 * 2**30}\n")
    (tmp_path / "memory.stat").write_text(f"anon {2**30}\nfile {2**30}\n")
    assert available.available_memory(system, tmp_path) == 2 * 2**30


def test_a_system_that_says_nothing_limits_nothing(tmp_path: Path) -> None:
    assert math.isinf(available.available_memory(tmp_path / "no", tmp_path / "none"))


@pytest.mark.parametrize(("memory", "workers"), [(0.0, 1), (3.5 * 2**30, 3), (math.inf, 8), (100 * 2**30, 8)])
def test_no_more_workers_than_fit_into_cores_and_memory(
    memory: float, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(available, "available_cores", lambda: 8)
    monkeypatch.setattr(available, "available_memory", lambda: memory)
    assert available.default_workers() == workers
