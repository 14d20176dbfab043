"""Device of a training: the processor, or a CUDA device with the same code."""

from __future__ import annotations

import importlib.util

from palpate.core import PalpateError


def find_device(name: str) -> str:
    """Resolve a device name to ``"cpu"`` or ``"cuda"``; ``"auto"`` is cuda if available.

    Raises
    ------
    PalpateError
        If cuda is chosen and missing.
    """
    if name == "cpu":
        return "cpu"
    if _has_cuda():
        return "cuda"
    if name == "auto":
        return "cpu"
    raise PalpateError(
        "This machine has no CUDA device that torch can use.", "Choose the device auto or cpu.", code="cuda-missing"
    )


def _has_cuda() -> bool:
    if importlib.util.find_spec("torch") is None:
        return False
    import torch  # seconds, so only where somebody asks for more than the processor

    return torch.cuda.is_available()
