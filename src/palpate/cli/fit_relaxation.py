"""Relaxation tests of `palpate material fit`: reading, fit and report."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from palpate.core import PalpateError
from palpate.core.report import Column, Report
from palpate.material import Material, Moduli, TestFileSpec

if TYPE_CHECKING:
    from palpate.material import RelaxationFit, RelaxationTest

_FILES = (
    "Files of relaxation tests: stress over time at constant strain. "
    "Files with 'relax' in their name are also read as such."
)
_MODULI = "Moduli that the constants of the law describe: long-term (slow tests) or instantaneous."
_ONTO = "Material whose law the relaxation is added to, if no other test is given: name in the library, or file."
_IS_RELAXATION = re.compile(r"relax(?!ed)", re.I)
_TESTS = (
    Column("name", "file"),
    Column("rows"),
    Column("came_s", "strain ramp", form=".3g", meaning="duration of the strain ramp"),
    Column("notes", prose=True),
)
_POOR = 0.01
"""Relative difference between fit and curve above which a warning is printed. By hand."""


@Parameter(name="*")
@dataclass(frozen=True)
class RelaxationFlags:
    """Relaxation tests, and the law that their series is added to."""

    relaxation: Annotated[tuple[Path, ...], Parameter(help=_FILES, consume_multiple=True, negative="")] = ()
    moduli: Annotated[Moduli, Parameter(help=_MODULI)] = Moduli.LONG_TERM
    onto: Annotated[str | None, Parameter(help=_ONTO)] = None


def is_relaxation(path: Path) -> bool:
    """Return whether a file is a relaxation test by its name."""
    return bool(_IS_RELAXATION.search(path.stem))


def fit_tests(
    files: Sequence[Path], bench: TestFileSpec, confidence: float, moduli: Moduli
) -> tuple[list[RelaxationTest], RelaxationFit] | None:
    """Read the tests and fit one series to them; `None` without files."""
    from palpate.material import fit_relaxation, read_relaxation

    if not files:
        return None
    tests = [read_relaxation(path, bench) for path in files]
    return tests, fit_relaxation(tests, confidence, moduli)


def find_law(flags: RelaxationFlags, output: Path | None, *, alone: bool) -> Material | None:
    """Return the material that a relaxation `alone` is added to; `None` without an output file."""
    from palpate.material import get_material

    if not alone:
        if flags.onto is not None:
            raise PalpateError(
                f"--onto {flags.onto} applies to relaxation tests alone, and other test files were given as well.",
                "Leave out --onto, or give only files of relaxation tests.",
                code="relaxation-onto-unused",
            )
        return None
    if flags.onto is None and output is not None:
        raise PalpateError(
            "A relaxation alone is not a material: it has no elastic law.",
            "Give its law by --onto NAME, or the files of a tensile test.",
            code="relaxation-without-law",
        )
    return replace(get_material(flags.onto), name=output.stem) if flags.onto is not None and output else None


def add_relaxation(material: Material, found: RelaxationFit) -> Material:
    """Return the material with the series, which is named in its quality."""
    quality = f"relaxation {found.first:.3g}…{found.last:.3g} s: within {100 * found.max_error:.2g} %"
    joined = "; ".join(part for part in (material.quality, quality) if part)
    return replace(material, relaxation=found.relaxation, quality=joined)


def describe_relaxation(tests: Sequence[RelaxationTest], found: RelaxationFit) -> dict[str, Any]:
    """Return a series as JSON data, with the tests that it was fitted to."""
    series = found.relaxation
    halves = zip(found.intervals[: len(series.shares)], found.intervals[len(series.shares) :], strict=True)
    times = [found.first, *(10.0**k for k in range(-6, 9) if found.first < 10.0**k < found.last), found.last]
    return {
        "samples": [
            {
                "name": test.name,
                "rows": len(test.time),
                "came_s": test.ramp_times[1] - test.ramp_times[0],
                "notes": list(test.notes),
            }
            for test in tests
        ],
        "moduli": str(series.moduli),
        "terms": [
            {
                "share": share,
                "share_interval": list(map(float, a)),
                "time_s": time,
                "time_interval": list(map(float, b)),
            }
            for share, time, (a, b) in zip(series.shares, series.times, halves, strict=True)
        ],
        "confidence": found.confidence,
        "first_s": found.first,
        "last_s": found.last,
        "left": [
            {"time_s": time, "left": float(series.relaxation_function(time)), "modulus": float(series.modulus(time))}
            for time in times
        ],
        "greatest": found.max_error,
        "rms": found.rms,
        "tried": [{"terms": terms, "aicc": aicc, "greatest": greatest} for terms, aicc, greatest in found.tried],
        "rows": found.count,
        "warnings": list(_warnings(found)),
    }


def _warnings(found: RelaxationFit) -> Iterator[str]:
    if found.max_error > _POOR:
        yield (
            f"The series deviates from the curve by up to {100 * found.max_error:.2g} %: the data are noisy, or "
            "their decay is not a sum of exponentials."
        )
    if np.isnan(found.intervals).any():
        yield "A time constant lies at the end of the measured times, so least squares gives no interval for it."


def relaxation_reports(facts: dict[str, Any]) -> Iterator[Report | str]:
    """Yield the tables and sentences of a `describe_relaxation` result."""
    yield Report("relaxation tests", _TESTS, facts["samples"])
    interval = f"{100 * facts['confidence']:g} % interval"
    terms = [
        (f"{term['share']:.5g}", _span(term["share_interval"]), f"{term['time_s']:.4g}", _span(term["time_interval"]))
        for term in facts["terms"]
    ]
    heads = ["share", f"{interval} of the share", "time (s)", f"{interval} of the time"]
    yield Report.of("relaxation (shares of the instantaneous stress)", heads, terms)
    left = [(f"{item['time_s']:.4g}", f"{item['left']:.4f}", f"{item['modulus']:.4f}") for item in facts["left"]]
    heads = ["time (s)", "over the instantaneous stress", f"over the {facts['moduli']} stress"]
    yield Report.of("stress after a step of strain", heads, left)
    greatest, rms = 100 * facts["greatest"], 100 * facts["rms"]
    yield f"{len(facts['terms'])} terms by AICc; maximum error {greatest:.2g} % of the curve, RMS error {rms:.2g} %"
    for warning in facts["warnings"]:
        yield f"Warning: {warning}"


def _span(ends: Sequence[float]) -> str:
    return "" if math.isnan(ends[0]) else f"{ends[0]:.4g} to {ends[1]:.4g}"
