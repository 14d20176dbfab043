"""Optional libraries."""

import sys
from pathlib import Path

import pytest

from errors import refused
from palpate import core
from palpate.core import load_extra


def test_load_extra_gives_the_library() -> None:
    assert load_extra("json", "none").loads("[1]") == [1]


def test_a_missing_library_is_named_with_the_command_that_installs_it() -> None:
    with refused("extra-missing", "No Such", ".[cad]"):
        load_extra("no_such_library", "cad", "No Such")


def test_a_library_that_lacks_one_of_the_system_says_which(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "half_there.py").write_text("raise ImportError('libGL.so.1: cannot open shared object file')")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "half_there", raising=False)
    with refused("library-unloadable", "half_there", "libGL.so.1", "palpate doctor"):
        load_extra("half_there", "cad")


def test_an_interrupt_that_a_compiled_module_wraps_stays_an_interrupt(tmp_path: Path, monkeypatch) -> None:
    lines = "try:\n    raise KeyboardInterrupt\nexcept KeyboardInterrupt as stop:\n    raise ImportError from stop"
    (tmp_path / "interrupted.py").write_text(lines)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "interrupted", raising=False)
    with pytest.raises(KeyboardInterrupt):
        load_extra("interrupted", "cad")


def test_an_unknown_public_name_is_an_attribute_error() -> None:
    assert not hasattr(core, "no_such_name")
    with pytest.raises(AttributeError):
        core.no_such_name  # noqa: B018
    assert "load_extra" in dir(core)
