"""`palpate material fit`: fit of a material to test files, with its range of validity."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.fit_relaxation import (
    RelaxationFlags,
    add_relaxation,
    describe_relaxation,
    find_law,
    fit_tests,
    is_relaxation,
    relaxation_reports,
)
from palpate.cli.flag import flags_of
from palpate.cli.output import Output, check_file
from palpate.core import PalpateError
from palpate.core.report import Column, Report
from palpate.material import FitSpec, Loading, Mode, PrepareSpec, TestFileSpec, list_models

if TYPE_CHECKING:
    from palpate.material import Fit, Material, Sample

_FILES = "Test files; the kind of test is read from the file's name or preamble."
_MODEL = f"Model: {', '.join(list_models())}."
_OUT = "Write the material to this YAML file, which --material and studies accept."
_FIGURE = "Figure of samples, mean and model (.png, .svg or .pdf)."
_RANK = "Fit one model only, without ranking of models and without errors of unmeasured modes."
_SAMPLES = (
    Column("name", "file"),
    Column("test"),
    Column("rows", deciding=False),
    Column("stretch", meaning="range of the stretch"),
    Column("greatest_kpa", "maximum stress", meaning="maximum nominal stress"),
    Column("notes", prose=True, deciding=False),
)
_MODES = (
    Column("mode"),
    Column("data"),
    Column("stretch", meaning="range of the stretch"),
    Column("r2", "R²", form=".6f", deciding=False, meaning="coefficient of determination"),
    Column("rmse_kpa", "RMSE", form=".4g", deciding=False),
    Column("relative", "error over maximum stress", meaning="RMSE over the maximum stress", prose=True),
)
_RANKING = (
    Column("model"),
    Column("behind", "ΔAICc", form=".1f", meaning="corrected Akaike criterion above that of the best model"),
    Column("relative", "error", "%", form=".3g", meaning="maximum RMSE of a mode over its maximum stress"),
    Column("left_out", "cross-validation error", "%", form=".3g", meaning="error of one sample left out of the fit"),
    Column("condition", form=".2g", meaning="condition number of the least squares"),
    Column("stable", meaning="Drucker stability in all modes"),
    Column("failure", prose=True),
)
_SENSED = 1.5
"""Maximum stretch of a pressed dome (docs/results/materials)."""
_UNTOLD = 1e3
"""Condition number above which the data do not determine the constants separately. By hand."""


def _of(loading: str) -> Parameter:
    return Parameter(help=f"Files of {loading}.", consume_multiple=True, negative="")


@Parameter(name="*")
@dataclass(frozen=True)
class FilesByTest:
    """Test files by kind of test, if name and preamble do not state it."""

    tension: Annotated[tuple[Path, ...], _of("tension")] = ()
    compression: Annotated[tuple[Path, ...], _of("compression")] = ()
    uniaxial: Annotated[tuple[Path, ...], _of("tension and compression in one curve, with signed stress")] = ()
    equibiaxial: Annotated[tuple[Path, ...], _of("equibiaxial tension")] = ()
    planar: Annotated[tuple[Path, ...], _of("planar tension (pure shear)")] = ()

    def pairs(self) -> Iterator[tuple[Path, Loading]]:
        """Yield every file with its test."""
        for loading in Loading:
            yield from ((path, loading) for path in getattr(self, str(loading)))


@Parameter(name="*")
@dataclass(frozen=True)
class CurveFlags:
    """Format of the test files and preparation of the curves."""

    bench: Annotated[TestFileSpec, flags_of(TestFileSpec, without="loading", group="Files")] = TestFileSpec()
    prepare: Annotated[PrepareSpec, flags_of(PrepareSpec, group="Curves")] = PrepareSpec()


@Parameter(name="*")
@dataclass(frozen=True)
class OutputFlags(Output):
    """Output files of the fit, and form of the printed results."""

    output: Annotated[Path | None, Parameter(name=["--output", "-o"], help=_OUT)] = None
    source: Annotated[str, Parameter(help="Source of the data, stored in the material's file.")] = ""
    licence: Annotated[str, Parameter(help="Licence of the data, stored in the material's file.")] = ""
    figure: Annotated[Path | None, Parameter(help=_FIGURE)] = None
    alone: Annotated[bool, Parameter(negative="", help=_RANK)] = False


@Parameter(name="*")
@dataclass(frozen=True)
class FitFlags:
    """Model and settings of the fit."""

    model: Annotated[str, Parameter(help=_MODEL)] = FitSpec().model
    how: Annotated[FitSpec, flags_of(FitSpec, without="model", group="Fit")] = FitSpec()

    @property
    def spec(self) -> FitSpec:
        """Settings of the fit with the model."""
        return self.how.model_copy(update={"model": self.model})


def fit(
    files: Annotated[tuple[Path, ...], Parameter(help=_FILES, negative="")] = (),
    *,
    tests: FilesByTest = FilesByTest(),
    relaxing: RelaxationFlags = RelaxationFlags(),
    curves: CurveFlags = CurveFlags(),
    fitting: FitFlags = FitFlags(),
    out: OutputFlags = OutputFlags(),
) -> None:
    """Fit a hyperelastic model and a relaxation to test files; report errors, intervals and stability."""
    from palpate.material import draw_fit, draw_relaxation, fit_material, write_material

    check_file(out.output)
    check_file(out.figure, ".png", ".svg", ".pdf")
    held = [*(path for path in files if is_relaxation(path)), *relaxing.relaxation]
    elastic = [*((path, None) for path in files if not is_relaxation(path)), *tests.pairs()]
    material = find_law(relaxing, out.output, alone=bool(held) and not elastic)
    series = fit_tests(held, curves.bench, fitting.how.confidence, relaxing.moduli)
    facts: dict[str, Any] = {}
    written = []
    if elastic or series is None:
        samples = read_samples(elastic, curves)
        found = fit_material(samples, fitting.spec)
        facts = describe_fit(samples, found, alone=out.alone)
        if out.figure is not None:
            written.append(_save(out.figure, draw_fit(samples, found)))
        if out.output is not None:
            material = _make_material(out, samples, found)
    if series is not None:
        facts["relaxation"] = describe_relaxation(*series)
        if out.figure is not None:
            path = out.figure.with_stem(f"{out.figure.stem}_relaxation") if elastic else out.figure
            written.append(_save(path, draw_relaxation(*series)))
        material = add_relaxation(material, series[1]) if material is not None else None
    if out.output is not None and material is not None:
        write_material(out.output, material)
        written.append(str(out.output))
    facts["files"] = written
    out.show(facts, *_reports(facts))


def _save(path: Path, figure: Any) -> str:
    from palpate.material import save_figure

    save_figure(path, figure)
    return str(path)


def read_samples(files: Sequence[tuple[Path, Loading | None]], flags: CurveFlags) -> list[Sample]:
    """Read and prepare the samples of files, each with its test or none."""
    from palpate.material import prepare_sample, read_test_file

    if not files:
        raise PalpateError(
            "No test files were given.",
            "Give the CSV files of a test: palpate material fit tension_*.csv.",
            code="argument-missing",
        )
    return [
        prepare_sample(sample, flags.prepare)
        for path, loading in files
        for sample in read_test_file(path, flags.bench.model_copy(update={"loading": loading}))
    ]


def _make_material(out: OutputFlags, samples: Sequence[Sample], found: Fit) -> Material:
    assert out.output is not None
    source = out.source or "fit to " + ", ".join(dict.fromkeys(sample.name for sample in samples))
    material = found.material(out.output.stem, source, out.licence)
    return replace(material, caution=" ".join(_instabilities(found)))


def describe_fit(samples: Sequence[Sample], found: Fit, *, alone: bool) -> dict[str, Any]:
    """Return a fit as JSON data: constants, quality, stability, and unless `alone` the ranking."""
    from palpate.material import compare_secants, extrapolate_modes, rank_models

    facts: dict[str, Any] = {
        "model": found.model.name,
        "samples": [_describe_sample(sample) for sample in samples],
        "constants": [
            {"name": name, "value": value, "low": float(low), "high": float(high)}
            for (name, value), (low, high) in zip(found.constants.items(), found.intervals, strict=True)
        ],
        "confidence": found.spec.confidence,
        "intervals_from": "samples" if found.from_samples else "rows",
        "shear_modulus_mpa": found.law.shear_modulus,
        "condition": found.condition,
        "aicc": found.aicc,
        "held": found.held,
        "modes": [{**vars(item), "mode": str(item.mode)} for item in found.quality],
        "stability": [{**vars(item), "mode": str(item.mode)} for item in found.stability],
        "stable": found.stable,
        "warnings": [*_warnings(found), *_warn_of_secants(samples, found)],
        "secants": [
            {"test": str(item.loading), "measured_mpa": item.measured, "fitted_mpa": item.fitted}
            for item in compare_secants(samples, found)
        ],
        "stable_fit": None if found.stable or found.spec.stable else _offer(samples, found),
    }
    if alone:
        return facts
    ranked = rank_models(samples, found.spec)
    facts["unseen"] = [{**vars(item), "mode": str(item.mode)} for item in extrapolate_modes(found, ranked, samples)]
    facts["ranking"] = [
        {
            "model": item.name,
            "behind": item.delta_aicc,
            "left_out": item.left_out,
            "relative": max(q.relative for q in item.fit.quality) if item.fit else math.nan,
            "condition": item.fit.condition if item.fit else math.nan,
            "stable": item.fit.stable if item.fit else None,
            "locks": bool(item.fit and item.fit.stable and not all(end.whole for end in item.fit.stability)),
            "failure": item.failure,
        }
        for item in ranked
    ]
    return facts


def _describe_sample(sample: Sample) -> dict[str, Any]:
    return {
        "name": sample.name,
        "test": str(sample.loading),
        "rows": len(sample.stretch),
        "low": float(sample.stretch.min()),
        "high": float(sample.stretch.max()),
        "greatest_mpa": float(abs(sample.nominal).max()),
        "notes": list(sample.notes),
    }


def _offer(samples: Sequence[Sample], found: Fit) -> dict[str, Any] | None:
    """Return the fit constrained to stability, or `None` if it fails."""
    from palpate.material import fit_material

    try:
        held = fit_material(samples, found.spec.model_copy(update={"stable": True}))
    except PalpateError:
        return None
    worst = min(held.quality, key=lambda item: item.r2)
    return {"constants": held.constants, "r2": worst.r2, "relative": worst.relative, "stable": held.stable}


def _instabilities(found: Fit) -> Iterator[str]:
    words = {Mode.UNIAXIAL: "uniaxial", Mode.EQUIBIAXIAL: "equibiaxial", Mode.PLANAR: "planar"}
    for item in found.stability:
        ends = [("below", item.low, item.low_locks), ("above", item.high, item.high_locks)]
        for locks, how in ((False, "Unstable (Drucker)"), (True, "Locked: no stress")):
            parts = [
                f"{side} a stretch of {end:.4g}" for side, end, at in ends if at is locks and not math.isnan(end)
            ]
            if parts:
                yield f"{how} in the {words[item.mode]} mode {' and '.join(parts)}."


def _warnings(found: Fit) -> Iterator[str]:
    yield from _instabilities(found)
    if not found.law.shear_modulus > 0:
        yield "The initial shear modulus is not positive: no press can be solved with this law."
    if found.condition > _UNTOLD:
        yield f"Condition number {found.condition:.2g}: these tests do not determine the constants separately."
    if found.held:
        yield "A bound or the stability constraint is active, so least squares gives no intervals."


def _warn_of_secants(samples: Sequence[Sample], found: Fit) -> Iterator[str]:
    """Yield a sentence with a flag if the fit is too stiff or too soft at small strain."""
    from palpate.material import SECANT_TOLERANCE, compare_secants

    secants = [item for item in compare_secants(samples, found) if abs(item.excess) > SECANT_TOLERANCE]
    if not secants:
        return
    worst = max(secants, key=lambda item: abs(item.excess))
    far = max(sample.stretch.max() for sample in samples)
    flag = f"--max-stretch {_SENSED:g}, the range of a sensor" if far > _SENSED else "--weighting relative"
    yield (
        f"At 10 % strain in {worst.loading} the fit's secant modulus is {1e3 * worst.fitted:.4g} kPa, that of the "
        f"data {1e3 * worst.measured:.4g} kPa ({100 * worst.excess:+.0f} %). A sensor works at small strain: "
        f"use {flag}."
    )


def _reports(facts: dict[str, Any]) -> Iterator[Report | str]:
    if "model" in facts:
        yield from _law_reports(facts)
    if "relaxation" in facts:
        yield from relaxation_reports(facts["relaxation"])
    for path in facts["files"]:
        yield f"Written: {path}"


def _law_reports(facts: dict[str, Any]) -> Iterator[Report | str]:
    samples = [
        item | {"stretch": _span(item["low"], item["high"], 4), "greatest_kpa": f"{1e3 * item['greatest_mpa']:.4g}"}
        for item in facts["samples"]
    ]
    yield Report("samples", _SAMPLES, samples)
    interval = f"{100 * facts['confidence']:g} % interval, from differences between {facts['intervals_from']}"
    constants = [
        (item["name"], f"{item['value']:.8g}", _span(item["low"], item["high"])) for item in facts["constants"]
    ]
    yield Report.of(f"{facts['model']} (MPa; exponents, Jm, lm: 1)", ("constant", "value", interval), constants)
    for item in facts["secants"]:
        moduli = f"data {1e3 * item['measured_mpa']:.4g} kPa, fit {1e3 * item['fitted_mpa']:.4g} kPa"
        yield f"secant modulus at 10 % strain, {item['test']}: {moduli}"
    yield f"initial shear modulus {1e3 * facts['shear_modulus_mpa']:.4g} kPa, condition {facts['condition']:.3g}"
    yield _mode_report(facts)
    for warning in facts["warnings"]:
        yield f"Warning: {warning}"
    if facts["stable_fit"]:
        held = facts["stable_fit"]
        values = ", ".join(f"{name} {value:.6g}" for name, value in held["constants"].items())
        yield f"With --stable: {values}; R² {held['r2']:.5f}, error {100 * held['relative']:.2g} %."
    if "ranking" in facts:
        yield _ranking_report(facts["ranking"])


def _mode_report(facts: dict[str, Any]) -> Report:
    rows: list[dict[str, Any]] = [
        {
            "mode": item["mode"],
            "data": "measured",
            "stretch": _span(item["low"], item["high"], 4),
            "r2": item["r2"],
            "rmse_kpa": 1e3 * item["rmse"],
            "relative": f"{100 * item['relative']:.3g} %",
        }
        for item in facts["modes"]
    ]
    for item in facts.get("unseen", []):
        predicted = f"about {100 * item['relative']:.2g} %, up to {100 * item['upper']:.2g} %"
        predicted = "unknown" if math.isnan(item["relative"]) else predicted
        stretch = _span(1.0, item["high"], 4)
        rows.append({"mode": item["mode"], "data": "not measured", "stretch": stretch, "relative": predicted})
    return Report("modes", _MODES, rows)


def _ranking_report(ranking: list[dict[str, Any]]) -> Report:
    rows = [
        {"model": item["model"], "failure": item["failure"]}
        if item["failure"]
        else {
            "model": item["model"],
            "behind": item["behind"],
            "relative": 100 * item["relative"],
            "left_out": 100 * item["left_out"],
            "condition": item["condition"],
            "stable": "until it locks" if item["locks"] else "yes" if item["stable"] else "NO",
        }
        for item in ranking
    ]
    return Report("models", _RANKING, rows)


def _span(low: float, high: float, digits: int = 6) -> str:
    return "" if math.isnan(low) else f"{low:.{digits}g} to {high:.{digits}g}"
