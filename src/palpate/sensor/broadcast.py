"""Readings for many clients: each has a short queue of its own, in which the oldest make way and are counted.

A client that stalls holds nobody up: its queue fills, loses its oldest readings, and the next reading that it gets
says how many were lost. So memory is bounded by the clients times the queue.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

Row = dict[str, Any]
"""A reading as plain data, by `palpate.sensor.reading_columns`, with `camera`."""
QUEUE = 120
"""Readings that wait for one client at most: two seconds of 60 images a second."""


class Listener:
    """What waits for one client.

    Parameters
    ----------
    most
        Readings that wait at most.

    Attributes
    ----------
    lost
        Readings that made way since the last `take`.
    """

    def __init__(self, most: int) -> None:
        self._waiting: deque[Row] = deque(maxlen=most)
        self._there = asyncio.Event()
        self.lost = 0

    def put(self, row: Row) -> None:
        """Append a reading; where there is no room, the oldest makes way."""
        self.lost += len(self._waiting) == self._waiting.maxlen
        self._waiting.append(row)
        self._there.set()

    async def take(self) -> Row:
        """The oldest reading that waits, with how many were lost before it as `lost`."""
        while not self._waiting:
            self._there.clear()
            await self._there.wait()
        row, lost = self._waiting.popleft(), self.lost
        self.lost = 0
        return row | {"lost": lost}


class Broadcast:
    """Hands every reading to every listener; used from one event loop.

    Parameters
    ----------
    most
        Readings that wait for one client at most.

    Attributes
    ----------
    last
        The newest reading; empty before the first.
    """

    def __init__(self, most: int = QUEUE) -> None:
        self._most, self._listeners = most, set[Listener]()
        self.last: Row = {}

    def __len__(self) -> int:
        """Number of listeners."""
        return len(self._listeners)

    def publish(self, row: Row) -> None:
        """Hand a reading to all."""
        self.last = row
        for listener in self._listeners:
            listener.put(row)

    @contextmanager
    def listen(self) -> Iterator[Listener]:
        """A listener, until the block ends."""
        listener = Listener(self._most)
        self._listeners.add(listener)
        try:
            yield listener
        finally:
            self._listeners.discard(listener)
