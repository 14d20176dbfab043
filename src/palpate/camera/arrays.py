"""Functions for numpy arrays and torch tensors, so that both are projected by the same code."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np


def array_module(values: Any) -> Any:
    """Return the module of an array's functions: torch for its tensors, numpy for all else."""
    torch = sys.modules.get("torch")
    return torch if torch is not None and isinstance(values, torch.Tensor) else np


def as_array(values: Any, like: Any = None) -> Any:
    """Convert real values to the kind, type and device of `like`; without it, tensors stay unchanged."""
    like = values if like is None else like
    module = array_module(like)
    if module is np:
        return np.asarray(values, float)
    return module.as_tensor(values, dtype=like.dtype, device=like.device)
