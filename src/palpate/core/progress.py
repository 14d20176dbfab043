"""Progress of long work: the cost planned, running and done, and the remaining time."""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

_MOST_PIECES = 1000
"""Maximum number of pieces of the pending work: an error of at most 0.1 %, in less than 1 ms."""


@dataclass
class _Piece:
    """A running piece: cost done before the time `begun`, s, and at its last advance `seen`, s.

    A worker's `first` piece includes its start: imports, compilation, opening of files.
    """

    what: str
    cost: float
    begun: float
    seen: float
    before: float
    done: float
    first: bool

    @property
    def measured(self) -> tuple[float, float]:
        """Cost done since it began, and the time that it took, s."""
        return self.done - self.before, self.seen - self.begun


class Progress:
    """Progress of work in pieces, some at the same time; this class shows nothing, its subclasses do.

    Costs are expected seconds of one worker, or any other measure of equal work; `clock` returns the time, s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._later: float | None = None
        self._reset(0.0)

    def _reset(self, cost: float) -> None:
        self.total, self.done = cost, 0.0
        self._running: list[_Piece] = []
        self._workers = 1
        self._ended: list[_Piece] = []

    def plan(self, cost: float, text: str = "") -> None:
        """Begin a part of the work with this cost in all; `text` describes it."""
        if self._later is None:
            self._reset(cost)
        else:
            self.total = self.done + cost + self._later

    def expect(self, cost: float) -> None:
        """Set the expected cost of all parts after the next one; from now on the parts are one work."""
        self._later = cost

    def begin(self, what: str, cost: float = 1.0, done: float = 0.0) -> None:
        """Begin a piece of the work, or resume one of which the cost `done` is done."""
        now = self._clock()
        first = len(self._running) == self._workers or not (self._running or self._ended)
        self._running.append(_Piece(what, cost, now, now, done, done, first))
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
        piece.done, piece.seen = piece.cost, self._clock()
        if not reason:
            self._ended.append(piece)

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
        cost is the mean so far. The first piece of a worker counts until further ones have as much cost.
        """
        now, running, ended = self._clock(), tuple(self._running), tuple(self._ended)
        cost, seconds = _sum_measured(one for one in (*ended, *running) if not one.first)
        first_cost, first_seconds = _sum_measured(one for one in (*ended, *running) if one.first)
        if cost < first_cost:
            cost, seconds = cost + first_cost, seconds + first_seconds
        if cost <= 0:
            return None
        ends = [max((one.cost - one.done) * seconds / cost - (now - one.seen), 0.0) for one in running]
        ends += [0.0] * (self._workers - len(running))
        heapq.heapify(ends)
        pending = max(self.total - self.done - sum(one.cost for one in running), 0.0)
        costs = [one.cost - one.before for one in ended if one.cost > one.before] or [one.cost for one in running]
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


def _sum_measured(pieces: Iterable[_Piece]) -> tuple[float, float]:
    """Cost of pieces so far, and the time that it took, s."""
    known = [one.measured for one in pieces]
    return sum(cost for cost, _ in known), sum(seconds for _, seconds in known)


def _duration_text(seconds: float) -> str:
    """Return a time in s, from two minutes in min (below ten with a decimal), from two hours in h."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    if seconds < 597:
        return f"{seconds / 60:.1f} min"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
