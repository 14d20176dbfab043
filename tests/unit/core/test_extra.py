"""Optional libraries."""

import sys
from pathlib import Path

from errors import refused
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
