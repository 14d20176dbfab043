"""Lines and bars of a long command on standard error."""

import pytest

from errors import check_values
from palpate.cli.progress import TerminalProgress


def test_every_part_of_a_search_begins_anew(capsys: pytest.CaptureFixture[str]) -> None:
    now = [0.0]
    progress = TerminalProgress(live=False, clock=lambda: now[0])
    for _ in range(2):
        progress.plan(20.0, "3 artefacts to make, 1 found")
        for name, cost, reason in (("press", 5.0, ""), ("twin", 5.0, "No press."), ("units", 10.0, "")):
            progress.begin(name, cost)
            now[0] += 60.0
            progress.finish(name, reason)
    progress.note("4 of 60 skins tried.")
    lines = capsys.readouterr().err.splitlines()
    assert lines[:4] == lines[4:8]
    expected = (
        (3, 1),
        ("[25 %, about 3.0 min remaining] press", "60.0 s"),
        ("[50 %", "twin", "No press."),
        ("[100 %",),
    )
    for line, values in zip(lines[:4], expected, strict=True):
        check_values(line, *values)
    assert lines[8:] == ["4 of 60 skins tried."]


def test_states_of_a_piece_are_lines_with_the_remaining_time(capsys: pytest.CaptureFixture[str]) -> None:
    now = [0.0]
    progress = TerminalProgress(live=False, clock=lambda: now[0])
    progress.plan(60.0)
    progress.begin("network", 60.0)
    now[0] = 100.0
    progress.advance("network", 1.0, "epoch 1 of 60")
    assert capsys.readouterr().err.splitlines() == ["[2 %, about 98 min remaining] network: epoch 1 of 60"]


def test_a_bar_begins_again_with_every_part() -> None:
    progress = TerminalProgress(live=True)
    for tasks in (3, 2):
        progress.plan(5.0 * tasks)
        progress.begin("press", 5.0)
        progress.finish("press")
        bar = progress.bar.tasks[0]
        assert (bar.completed, bar.total) == (pytest.approx(1 / tasks), 1.0)
        assert "remaining" in progress.bar.columns[3].render(bar).plain  # type: ignore[union-attr]
