"""Random streams: each stage draws from its own, named by labels below the study's seed."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np


def child_seed(seed: int, *labels: str | float) -> int:
    """Return the seed of the stream `labels` below `seed`; other labels give an independent stream.

    Labels are words and numbers, e.g. ``"dataset", 20.0, 2.0``. The seed, in 0 … 2³² − 1, is the same on every
    machine and Python version.

    Examples
    --------
    >>> child_seed(0, "poses") == child_seed(0, "poses")
    True
    >>> child_seed(0, "poses") == child_seed(0, "jitter")
    False
    """
    text = json.dumps([seed, *labels])
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")


def generator(seed: int, *labels: str | float) -> np.random.Generator:
    """Return the random generator of the stream `labels` below `seed` (see `child_seed`).

    Examples
    --------
    >>> bool(generator(0, "poses").random() == generator(0, "poses").random())
    True
    """
    import numpy as np

    return np.random.default_rng(child_seed(seed, *labels))
