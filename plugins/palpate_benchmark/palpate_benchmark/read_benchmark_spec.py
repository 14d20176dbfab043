"""Specs of the data set and of its baselines, from a preset or a YAML file."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from palpate.core import PalpateError, Spec
from palpate.study import read_spec
from palpate_benchmark.spec import PRESETS, TINY_BASELINES, BaselineSpec, BenchmarkSpec

Given = TypeVar("Given", bound=Spec)


def read_benchmark_spec(source: str) -> BenchmarkSpec:
    """Read the spec of a data set from a preset or a YAML file.

    Raises
    ------
    PalpateError
        If the source is neither, or the file is invalid.
    """
    if source in PRESETS:
        return PRESETS[source]
    return _read(source, BenchmarkSpec, f"Choose one of {', '.join(PRESETS)}, or give a YAML file.")


def read_baseline_spec(source: str | None) -> BaselineSpec:
    """Read the settings of the baselines: the default, the preset ``tiny``, or a YAML file.

    Raises
    ------
    PalpateError
        If the file is missing or invalid.
    """
    if source is None:
        return BaselineSpec()
    if source == "tiny":
        return TINY_BASELINES
    return _read(source, BaselineSpec, "Omit it, or give tiny or a YAML file.")


def _read(source: str, kind: type[Given], hint: str) -> Given:
    path = Path(source)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise PalpateError(
            f"'{source}' is neither a preset nor a readable file.", hint, code="preset-unknown"
        ) from error
    return read_spec(path, text, kind, hint)
