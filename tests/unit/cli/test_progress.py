"""What a long command says of itself on standard error."""

import pytest

from palpate.cli.progress import Bars, Lines, make_progress


def test_every_part_of_a_search_is_counted_from_one(capsys: pytest.CaptureFixture[str]) -> None:
    lines = Lines()
    for _ in range(2):
        lines.planned(2, 1, 10.0)
        lines.ended("press", 5.0, 1.0, "")
        lines.ended("twin", 5.0, 1.0, "No press.")
    lines.message("4 of 60 skins tried.")
    said = capsys.readouterr().err.splitlines()
    part = ["2 artefacts to make, 1 found", "[1/2] press: done in 1.0 s", "[2/2] twin: No press."]
    assert said == [*part, *part, "4 of 60 skins tried."]


def test_a_bar_begins_again_with_every_part() -> None:
    progress = make_progress()
    bars = Bars(progress)
    for tasks in (3, 2):
        bars.planned(tasks, 0, 10.0)
        bars.started("press")
        bars.ended("press", 5.0, 1.0, "")
        assert (progress.tasks[0].completed, progress.tasks[0].total) == (1, tasks)
