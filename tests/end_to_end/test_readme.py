"""What README and docs show in Python can be typed as it stands."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "tutorials").glob("*.md")]


def blocks(page: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)


def test_the_first_program_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(blocks(ROOT / "README.md")[0], "README.md", "exec"), {})
    assert capsys.readouterr().out.startswith("depth reached [")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_name_that_a_page_imports_is_there(page: Path) -> None:
    asked = re.findall(r"^from (palpate[\w.]*) import ([\w, ]+)$", "\n".join(blocks(page)), re.M)
    names = [(module, name.strip()) for module, listed in asked for name in listed.split(",")]
    assert [pair for pair in names if not hasattr(importlib.import_module(pair[0]), pair[1])] == []
