"""What a long command says of itself on standard error."""

import pytest

from errors import check_values
from palpate.cli.progress import Bars, Lines, make_progress


def test_every_part_of_a_search_is_counted_from_one(capsys: pytest.CaptureFixture[str]) -> None:
    lines = Lines()
    for _ in range(2):
        lines.planned(2, 1, 10.0)
        lines.ended("press", 5.0, 1.0, "")
        lines.ended("twin", 5.0, 1.0, "No press.")
    lines.message("4 of 60 skins tried.")
    said = capsys.readouterr().err.splitlines()
    assert said[:3] == said[3:6]
    for line, values in zip(said[:3], ((2, 1), ("[1/2] press", "1.0 s"), ("[2/2] twin", "No press.")), strict=True):
        check_values(line, *values)
    assert said[6:] == ["4 of 60 skins tried."]


def test_a_bar_begins_again_with_every_part() -> None:
    progress = make_progress()
    bars = Bars(progress)
    for tasks in (3, 2):
        bars.planned(tasks, 0, 10.0)
        bars.started("press")
        bars.ended("press", 5.0, 1.0, "")
        assert (progress.tasks[0].completed, progress.tasks[0].total) == (1, tasks)
