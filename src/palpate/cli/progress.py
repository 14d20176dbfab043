"""How a study goes, on standard error: bars with remaining time on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from collections import Counter

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column

from palpate.study import Observer


class Lines(Observer):
    """One plain line for every task that ends."""

    def __init__(self) -> None:
        self._tasks = 0
        self._done = 0

    def planned(self, tasks: int, reused: int, cost: float) -> None:
        """Say how much is to be done."""
        self._tasks, self._done = tasks, 0
        _describe(f"{tasks} artefacts to make, {reused} found")

    def started(self, task: str) -> None:
        """Say nothing: lines are for what has ended."""

    def ended(self, task: str, cost: float, seconds: float, reason: str) -> None:
        """Say how a task ended."""
        self._done += 1
        _describe(f"[{self._done}/{self._tasks}] {task}: {reason or f'done in {seconds:.1f} s'}")

    def message(self, sentence: str) -> None:
        """Say it."""
        _describe(sentence)


class Bars(Observer):
    """One bar over all tasks, the names of those at work, and the remaining time."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._working: Counter[str] = Counter()
        self._bar = progress.add_task("study", total=None, working="", left="")
        self._costs = [0.0, 0.0]

    def planned(self, tasks: int, reused: int, cost: float) -> None:
        """Set the length of the bar."""
        self._costs = [0.0, cost]
        self._progress.reset(self._bar, total=tasks)
        self._progress.console.print(f"{tasks} artefacts to make, {reused} found")

    def started(self, task: str) -> None:
        """Name the task beside the bar."""
        self._working[task] += 1
        self._show()

    def ended(self, task: str, cost: float, seconds: float, reason: str) -> None:
        """Move the bar; keep the line of a failure."""
        self._working.pop(task, None)
        self._costs[0] += cost
        self._progress.advance(self._bar)
        if reason:
            self._progress.console.print(f"{task}: {reason}", style="red", markup=False)
        self._show()

    def message(self, sentence: str) -> None:
        """Print it above the bar."""
        self._progress.console.print(sentence, markup=False)

    def _show(self) -> None:
        done, total = self._costs
        elapsed = self._progress.tasks[0].elapsed or 0.0
        left = f"about {_duration(elapsed * (total - done) / done)} left" if done else ""
        self._progress.update(self._bar, working=", ".join(self._working), left=left)


def _duration(seconds: float) -> str:
    """A time in seconds, from two minutes on in minutes, from two hours on in hours."""
    return (
        f"{seconds:.0f} s"
        if seconds < 120
        else f"{seconds / 60:.0f} min"
        if seconds < 7200
        else f"{seconds / 3600:.1f} h"
    )


def make_progress() -> Progress:
    """A bar on standard error; nothing is drawn before it is started."""
    return Progress(
        BarColumn(bar_width=16),
        MofNCompleteColumn(table_column=Column(no_wrap=True, min_width=9)),
        TimeElapsedColumn(table_column=Column(no_wrap=True, min_width=7)),
        TextColumn("{task.fields[left]}", table_column=Column(no_wrap=True, min_width=18)),
        TextColumn("{task.fields[working]}", table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1)),
        console=Console(stderr=True),
        expand=True,
    )


def _describe(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
