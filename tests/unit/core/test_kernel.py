"""Compiled kernels and where their machine code lies."""

import importlib
import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np
import pytest

from palpate.core import kernel
from palpate.core.kernel import kernel_stamp, remove_stale


@kernel
def _sum(values: np.ndarray) -> float:
    total = 0.0
    for value in values:
        total += value
    return total


def test_a_kernel_computes_and_nan_keeps_its_meaning() -> None:
    assert _sum(np.array([1.0, 2.0, 3.5])) == 6.5
    assert np.isnan(_sum(np.array([1.0, np.nan])))


def test_kernel_leaves_the_users_cache_folder_as_it_is() -> None:
    assert "kernels-" not in str(numba.config.CACHE_DIR)
    assert "kernels-" in _sum.compiled.stats.cache_path


def _folder(place: Path, name: str, age_s: float, inner_age_s: float | None = None) -> Path:
    folder = place / name
    (folder / "palpate_1").mkdir(parents=True)
    file = folder / "palpate_1" / "code.nbc"
    file.write_bytes(b"code")
    for path, age in ((file, inner_age_s or age_s), (file.parent, age_s), (folder, age_s)):
        os.utime(path, (time.time() - age, time.time() - age))
    return folder


def test_machine_code_that_nothing_has_used_for_a_month_is_removed(tmp_path: Path) -> None:
    day = 86_400.0
    old = _folder(tmp_path, "kernels-old", 31 * day)
    mine = _folder(tmp_path, "kernels-mine", 99 * day)
    young = _folder(tmp_path, "kernels-young", 29 * day)
    written = _folder(tmp_path, "kernels-written", 40 * day, inner_age_s=day)
    other = _folder(tmp_path, "elsewhere", 99 * day)
    assert remove_stale(tmp_path, {mine.name}) == ("kernels-old",)
    assert not old.exists()
    assert all(folder.is_dir() for folder in (mine, young, written, other))
    assert remove_stale(tmp_path, {mine.name}) == ()
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "elsewhere",
        "kernels-mine",
        "kernels-written",
        "kernels-young",
    ]


def test_two_processes_that_remove_at_once_do_not_disturb_each_other(tmp_path: Path) -> None:
    for number in range(40):
        _folder(tmp_path, f"kernels-{number}", 1e8)
    with ThreadPoolExecutor(4) as pool:
        removed = [name for names in pool.map(lambda _: remove_stale(tmp_path, ()), range(4)) for name in names]
    assert sorted(removed) == sorted(f"kernels-{number}" for number in range(40))
    assert list(tmp_path.iterdir()) == []


def test_the_folder_in_use_is_marked_as_used() -> None:
    assert time.time() - Path(_sum.compiled.stats.cache_path).parent.stat().st_mtime < 30 * 86_400.0


def test_any_source_with_a_kernel_changes_the_stamp(tmp_path: Path) -> None:
    (tmp_path / "law.py").write_text("@kernel\ndef law(): return 1\n")
    (tmp_path / "plain.py").write_text("a = 1\n")
    first = kernel_stamp(tmp_path)
    kernel_stamp.cache_clear()
    (tmp_path / "plain.py").write_text("a = 2\n")
    assert kernel_stamp(tmp_path) == first
    kernel_stamp.cache_clear()
    (tmp_path / "law.py").write_text("@kernel\ndef law(): return 2\n")
    assert kernel_stamp(tmp_path) != first
    kernel_stamp.cache_clear()


def test_a_kernel_of_another_package_lies_in_a_folder_of_both(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "guest_of_kernels"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "one.py").write_text("from palpate.core import kernel\n\n\n@kernel\ndef one(x):\n    return x\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    one = importlib.import_module("guest_of_kernels.one").one
    assert one(2.0) == 2.0
    assert f"-{kernel_stamp(package)}" in one.compiled.stats.cache_path
    assert kernel_stamp(package) not in _sum.compiled.stats.cache_path
