"""Progress on standard error: a bar with the remaining time on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich import progress as bars
from rich.console import Console
from rich.table import Column
from rich.text import Text

from palpate.core.run import Progress


class TerminalProgress(Progress):
    """Progress as one line per event, or as a bar on a terminal.

    Parameters
    ----------
    live
        Whether the bar is drawn; notes and failures are printed above it.
    clock
        Returns the time, s.
    """

    def __init__(self, live: bool, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(clock)
        self._console = Console(stderr=True)
        self._state = ""
        self.bar = bars.Progress(
            bars.BarColumn(bar_width=16),
            bars.TaskProgressColumn(table_column=Column(no_wrap=True, min_width=4)),
            bars.TimeElapsedColumn(table_column=Column(no_wrap=True, min_width=7)),
            _RemainingColumn(self),
            bars.TextColumn(
                "{task.fields[running]}",
                markup=False,
                table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1),
            ),
            console=self._console,
            disable=not live,
            expand=True,
        )
        self._task = self.bar.add_task("", total=None, running="")

    def plan(self, cost: float, text: str = "") -> None:
        super().plan(cost, text)
        self._state = ""
        if not self.done:
            self.bar.reset(self._task, total=1.0, running="")
        self._print(text)

    def begin(self, what: str, cost: float = 1.0, done: float = 0.0) -> None:
        super().begin(what, cost, done)
        self._show()

    def advance(self, what: str, done: float, text: str = "") -> None:
        super().advance(what, done, text)
        self._state = text
        self._show()
        if self.bar.disable and text:
            self._print(f"{self._position()}{what}: {text}")

    def finish(self, what: str, reason: str = "") -> None:
        seconds = self._clock() - self._find(what).begun
        super().finish(what, reason)
        self._state = ""
        self._show()
        if self.bar.disable:
            self._print(f"{self._position()}{what}: {reason or f'done in {seconds:.1f} s'}")
        elif reason:
            self._print(f"{what}: {reason}")

    def note(self, text: str) -> None:
        self._print(text)

    def _show(self) -> None:
        running = ", ".join([*dict.fromkeys(piece.what for piece in self._running), self._state]).rstrip(", ")
        self.bar.update(self._task, completed=self.share, running=running)

    def _position(self) -> str:
        """Return the completed share and the remaining time in brackets."""
        return f"[{', '.join(filter(None, (f'{100 * self.share:.0f} %', self.remaining_text)))}] "

    def _print(self, text: str) -> None:
        if self.bar.disable and text:
            print(text, file=sys.stderr, flush=True)
        elif text:
            self._console.print(text, markup=False, highlight=False)


class _RemainingColumn(bars.ProgressColumn):
    """Remaining time, computed at every drawing of the bar."""

    def __init__(self, progress: Progress) -> None:
        super().__init__(Column(no_wrap=True, min_width=23))
        self._progress = progress

    def render(self, task: bars.Task) -> Text:
        return Text(self._progress.remaining_text)


@contextmanager
def show_progress(quiet: bool = False) -> Iterator[TerminalProgress]:
    """Show the progress of the block on standard error; without a bar if `quiet` or not on a terminal."""
    progress = TerminalProgress(sys.stderr.isatty() and not quiet)
    with progress.bar:
        yield progress
