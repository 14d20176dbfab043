"""Distribution of readings to many clients, each with a short queue.

A stalled client delays no other client: its full queue drops the oldest readings, and the next reading that it takes
contains their number. Memory is bounded by the number of clients times the queue length.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

Row = dict[str, Any]
"""Reading as plain data, by `palpate.sensor.reading_columns`, with `camera`."""
QUEUE = 120
"""Maximum number of readings queued for one client: two seconds at 60 images per second. By hand."""


class Listener:
    """Queue of at most `most` readings for one client; `lost` counts those dropped since the last `take`."""

    def __init__(self, most: int) -> None:
        self._waiting: deque[Row] = deque(maxlen=most)
        self._there = asyncio.Event()
        self.lost = 0

    def put(self, row: Row) -> None:
        """Append a reading; a full queue drops its oldest."""
        self.lost += len(self._waiting) == self._waiting.maxlen
        self._waiting.append(row)
        self._there.set()

    async def take(self) -> Row:
        """Return the oldest queued reading, with the number of readings dropped before it as `lost`."""
        while not self._waiting:
            self._there.clear()
            await self._there.wait()
        row, lost = self._waiting.popleft(), self.lost
        self.lost = 0
        return row | {"lost": lost}


class Broadcast:
    """Distributor of every reading to every listener; used from one event loop.

    Each queue holds at most `most` readings; `last` is the newest reading, empty before the first.
    """

    def __init__(self, most: int = QUEUE) -> None:
        self._most, self._listeners = most, set[Listener]()
        self.last: Row = {}

    def __len__(self) -> int:
        """Number of listeners."""
        return len(self._listeners)

    def publish(self, row: Row) -> None:
        """Queue a reading for all listeners."""
        self.last = row
        for listener in self._listeners:
            listener.put(row)

    @contextmanager
    def listen(self) -> Iterator[Listener]:
        """Register a listener until the block ends."""
        listener = Listener(self._most)
        self._listeners.add(listener)
        try:
            yield listener
        finally:
            self._listeners.discard(listener)
