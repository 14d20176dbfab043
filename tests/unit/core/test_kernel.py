"""Compiled kernels and where their machine code lies."""

import importlib
from pathlib import Path

import numba
import numpy as np
import pytest

from palpate.core import kernel
from palpate.core.kernel import kernel_stamp


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
    assert "kernels-" in _sum.stats.cache_path


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
    assert f"-{kernel_stamp(package)}" in one.stats.cache_path
    assert kernel_stamp(package) not in _sum.stats.cache_path
