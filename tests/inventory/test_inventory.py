"""Everything that 0.2.0 had has its place: names of verbs, flags, classes, kinds, studies, examples and extras."""

import json
import subprocess
import sys
from pathlib import Path

from inventory.commands import COMMANDS, NOT_RUN
from inventory.compare import RENAMES, ROOT, compare_names, compare_values

BEFORE = Path(__file__).with_name("before_restructure.json")
"""Inventory of the tag `before-restructure`, by `collect.py`."""


def test_every_name_of_before_has_its_place() -> None:
    words = [sys.executable, str(Path(__file__).with_name("collect.py")), str(ROOT)]
    done = subprocess.run(words, cwd=ROOT / "src", capture_output=True, text=True, check=True)
    assert list(compare_names(json.loads(BEFORE.read_text()), json.loads(done.stdout))) == []


def test_every_verb_is_compared_or_has_a_reason() -> None:
    verbs = {name.partition(",")[0] for name in COMMANDS} | set(NOT_RUN)
    assert verbs == set(json.loads(BEFORE.read_text())["verb"])


def test_what_has_gone_has_a_reason() -> None:
    rows = [line.split(",", 3) for line in RENAMES.read_text().splitlines()[1:]]
    assert [row for row in rows if not row[2] and not row[3].strip()] == []


def test_a_changed_number_is_a_difference() -> None:
    old = {"rmse_deg": 0.25, "rows": [{"markers": 7}], "seconds": 1.0}
    assert list(compare_values(old, {"rmse_deg": 0.25, "rows": [{"markers": 7}], "seconds": 2.0})) == []
    assert len(list(compare_values(old, {"rmse_deg": 0.2500001, "rows": [{"markers": 8}]}))) == 2
    assert len(list(compare_values(old, {"rows": []}))) == 2
