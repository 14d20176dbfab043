"""Progress of long work: the cost planned, running and done, and the remaining time."""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable
from dataclasses import dataclass

_MOST_PIECES = 1000
"""Maximum number of pieces of the pending work: an error of at most 0.1 %, in less than 1 ms."""


@dataclass
class _Piece:
    """A running piece: cost done before the time `begun`, s, and at its last advance `seen`, s."""

    what: str
    cost: float
    begun: float
    seen: float
    before: float
    done: float


class Progress:
    """Progress of work in pieces, some at the same time; this class shows nothing, its subclasses do.

    Costs are expected seconds of one worker, or any other measure of equal work; `clock` returns the time, s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._reset(0.0)

    def _reset(self, cost: float) -> None:
        self.total, self.done = cost, 0.0
        self._running: list[_Piece] = []
        self._workers = 1
        self._measured: list[tuple[float, float]] = []

    def plan(self, cost: float, text: str = "") -> None:
        """Begin a part of the work with this cost in all; `text` describes it."""
        self._reset(cost)

    def begin(self, what: str, cost: float = 1.0, done: float = 0.0) -> None:
        """Begin a piece of the work, or resume one of which the cost `done` is done."""
        now = self._clock()
        self._running.append(_Piece(what, cost, now, now, done, done))
        self._workers = max(self._workers, len(self._running))

    def advance(self, what: str, done: float, text: str = "") -> None:
        """Set the cost done of a running piece; `text` describes its state."""
        piece = self._find(what)
        piece.done, piece.seen = min(done, piece.cost), self._clock()

    def finish(self, what: str, reason: str = "") -> None:
        """End a running piece; `reason` is empty, or one sentence on its failure."""
        piece = self._find(what)
        self._running.remove(piece)
        self.done += piece.cost
        if not reason:
            self._measured.append((piece.cost - piece.before, self._clock() - piece.begun))

    def note(self, text: str) -> None:
        """Show a sentence on the work."""

    @property
    def share(self) -> float:
        """Share of the work that is done, 0 to 1."""
        done = self.done + sum(piece.done for piece in tuple(self._running))
        return min(done / self.total, 1.0) if self.total > 0 else 0.0

    @property
    def remaining_s(self) -> float | None:
        """Expected remaining time, s; `None` until the speed is known.

        The running pieces end as the speed so far predicts; each worker that is free takes a pending piece, whose
        cost is the mean so far.
        """
        now, running, measured = self._clock(), tuple(self._running), tuple(self._measured)
        known = [*measured, *((one.done - one.before, one.seen - one.begun) for one in running)]
        cost, seconds = (sum(column) for column in zip(*known, strict=True)) if known else (0.0, 0.0)
        if cost <= 0:
            return None
        ends = [max((one.cost - one.done) * seconds / cost - (now - one.seen), 0.0) for one in running]
        ends += [0.0] * (self._workers - len(running))
        heapq.heapify(ends)
        pending = max(self.total - self.done - sum(one.cost for one in running), 0.0)
        costs = [each for each, _ in measured if each > 0] or [one.cost for one in running]
        pieces = min(max(round(pending * len(costs) / sum(costs)), 1), _MOST_PIECES)
        for _ in range(pieces if pending > 0 else 0):
            heapq.heapreplace(ends, ends[0] + pending / pieces * seconds / cost)
        return max(ends)

    @property
    def remaining_text(self) -> str:
        """Expected remaining time in words; empty before it is known and after it has passed."""
        seconds = self.remaining_s
        return f"about {_duration_text(seconds)} remaining" if seconds else ""

    def _find(self, what: str) -> _Piece:
        return next(piece for piece in self._running if piece.what == what)


def _duration_text(seconds: float) -> str:
    """Return a time in s, from two minutes in min, from two hours in h."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
