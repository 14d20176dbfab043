"""Versions of artefacts: the behaviour stamp of a stage, numeric libraries, and plug-ins.

`behaviour.json` contains, for each stage, the results of small reference cases. The stamp of a stage is the hash of
its results. A test computes the cases again and fails if a result differs beyond rounding; then
``python tests/behaviour/results.py STAGE`` writes the new results, and with them a new stamp. A change of names or
messages leaves results and stamps as they are, so that stored artefacts stay valid.
"""

from __future__ import annotations

import hashlib
import json
import sys
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

from palpate.core.errors import PalpateError
from palpate.core.provenance import installed_version

BEHAVIOUR_FILE = Path(__file__).with_name("behaviour.json")
"""Results of the reference cases: stage → case → name → numbers."""

_LIBRARIES = ("numpy", "scipy", "numba", "py-mkl-pardiso", "rslab")
"""Distributions that affect the digits of a result: arrays, compiled kernels, sparse linear solvers."""
_VISION, _TRAINING = ("opencv-python-headless", "opencv-python"), ("torch",)
_STAGE_LIBRARIES = {
    "detections": _VISION,
    "unit_trial": _VISION,
    "skin_evaluation": _VISION,
    "benchmark_unit": _VISION,
    "estimator": _TRAINING,
    "force_estimator": _TRAINING,
    "recorded_estimator": (*_VISION, *_TRAINING),
    "baseline": (*_VISION, *_TRAINING),
}
"""Further distributions that affect the results of a stage."""


def stage_version(stage: str, *parts: object) -> str:
    """Return the version of the artefacts of a stage, a part of their keys.

    Parameters
    ----------
    stage
        Name of the stage in `behaviour.json`.
    parts
        Specs, laws and other objects that take part; a class of another package adds the version of that package.

    Raises
    ------
    PalpateError
        If the stage has no reference case.
    """
    libraries = _library_versions((*_LIBRARIES, *_STAGE_LIBRARIES.get(stage, ())))
    return "; ".join([behaviour_stamp(stage), *libraries, *sorted({*map(_plugin_version, parts)} - {""})])


@cache
def behaviour_stamp(stage: str) -> str:
    """Return the hash of the reference results of a stage, 16 hexadecimal digits.

    Raises
    ------
    PalpateError
        If the stage has no reference case.
    """
    results = json.loads(BEHAVIOUR_FILE.read_bytes())
    if stage not in results:
        raise PalpateError(
            f"The stage '{stage}' has no reference case.",
            f"Choose one of {', '.join(results)}.",
            code="stage-unknown",
        )
    return hashlib.sha256(json.dumps(results[stage], sort_keys=True).encode()).hexdigest()[:16]


@cache
def _library_versions(names: tuple[str, ...]) -> tuple[str, ...]:
    found = {name: installed_version(name) for name in names}
    return tuple(f"{name} {version}" for name, version in found.items() if version is not None)


def _plugin_version(part: object) -> str:
    kind: Any = part if isinstance(part, type) else type(part)
    top = kind.__module__.partition(".")[0]
    return "" if top == __name__.partition(".")[0] or top in sys.stdlib_module_names else _package_version(top)


@cache
def _package_version(top: str) -> str:
    """Return the distributions of a top-level module with versions; its source's hash if not installed."""
    names = sorted(set(packages_distributions().get(top, ())))
    if names:
        return ", ".join(f"{name} {installed_version(name)}" for name in names)
    source = getattr(sys.modules.get(top), "__file__", None)
    return f"{top} {hashlib.sha256(Path(source).read_bytes()).hexdigest()[:16]}" if source else top
