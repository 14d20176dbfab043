"""Randomness as an argument: each stage draws from its own stream, named below the study's seed."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np


def child_seed(seed: int, *labels: str | float) -> int:
    """Seed of the stream called `labels` below `seed`; other labels give an independent stream.

    Parameters
    ----------
    seed
        Seed of the parent, any integer.
    *labels
        Words and numbers that name the stream, e.g. ``"dataset", 20.0, 2.0``.

    Returns
    -------
    int
        A seed in 0 … 2³² − 1, the same on every machine and Python version.

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
    """Random generator of the stream called `labels` below `seed` (see `child_seed`).

    Examples
    --------
    >>> bool(generator(0, "poses").random() == generator(0, "poses").random())
    True
    """
    import numpy as np

    return np.random.default_rng(child_seed(seed, *labels))
