"""Specs of the set and of its baselines by the name of a preset, or from a YAML file."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from palpate.core import PalpateError, Spec
from palpate.study import read_spec
from palpate_benchmark.spec import PRESETS, TINY_BASELINES, BaselineSpec, BenchmarkSpec

Given = TypeVar("Given", bound=Spec)


def read_benchmark_spec(source: str) -> BenchmarkSpec:
    """What a set holds, by the name of a preset or from a YAML file.

    Raises
    ------
    PalpateError
        If there is neither, or the file is no valid one.
    """
    if source in PRESETS:
        return PRESETS[source]
    return _read(source, BenchmarkSpec, f"The presets are {', '.join(PRESETS)}.")


def read_baseline_spec(source: str | None) -> BaselineSpec:
    """How baselines are made: as documented, in seconds (``tiny``), or by a YAML file.

    Raises
    ------
    PalpateError
        If there is no such file, or it is no valid one.
    """
    if source is None:
        return BaselineSpec()
    if source == "tiny":
        return TINY_BASELINES
    return _read(source, BaselineSpec, "Leave it out, or give tiny.")


def _read(source: str, kind: type[Given], hint: str) -> Given:
    path = Path(source)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise PalpateError(
            f"There is neither a preset nor a readable file '{source}'.", hint, code="preset-unknown"
        ) from error
    return read_spec(path, text, kind, hint)
