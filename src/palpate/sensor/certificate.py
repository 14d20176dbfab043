"""Certificate of an acceptance test: decisions, uncertainty of a reading, inputs, limits of validity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from palpate.calibration import UncertaintyBudget
from palpate.core import PalpateError, wrap_write_errors
from palpate.core.report import Report
from palpate.design import wall_normal
from palpate.sensor.accept import Acceptance, AcceptanceCheck
from palpate.sensor.draw_certificate import write_pages
from palpate.sensor.gauge_study import ANGLES, REPEATABILITY, REPRODUCIBILITY, GaugeStudy
from palpate.sensor.report import provenance_line, write_report
from palpate.sensor.score import PAPER_TABLE_3

_SEATING, _NOISE = "seating, tilt", "marker noise, of the image and at rest"
"""Lines of the budget that remounting replaces, and with which repeatability is compared."""
_UNSTATED = (
    "No reference standard is stated, so that nothing is proven: figures ± U are within or outside the tolerance."
)
_CHECKS = ("figure", "value", "U (k = 2)", "tolerance", "decision")
_FIELDS = (
    "Certificate number, date and place of the test",
    "Tested by (name, signature)",
    "Approved by (name, signature)",
)
_PAPER = "Zaid et al. 2024, RMSE / MAE / max / SD"


@dataclass(frozen=True)
class Certificate:
    """Certificate of one unit.

    Attributes
    ----------
    found
        Acceptance test.
    title
        Name of the unit.
    inputs
        Description of each input → its name, with the SHA-256 hash of files.
    budget
        Uncertainty budget of the unit by its twin; `None` for another estimator.
    study
        Gauge repeatability and reproducibility study.
    """

    found: Acceptance
    title: str
    inputs: Mapping[str, str] = field(default_factory=dict)
    budget: UncertaintyBudget | None = None
    study: GaugeStudy | None = None

    @property
    def verdict(self) -> str:
        """``passed``, with a note if no reference standard is stated, or the failed checks."""
        failed = [f"{each.what} ({each.decision})" for each in self.found.checks if not each.passed]
        if failed:
            return f"failed: {', '.join(failed)}"
        return "passed" if self.found.reference.reference else "passed; reference standard not stated"

    def reading_budget(self) -> UncertaintyBudget:
        """Return the budget of a reading: by the twin (type B), and by recording and gauge study (type A).

        The recorded errors are a sample of the combined error. Only their excess over these lines is added, so
        that nothing is counted twice. Reproducibility over mountings replaces the tolerance of the seating, unless
        mountings have fewer than 4 degrees of freedom. Repeatability is added as far as it exceeds the marker noise.
        The reference standard is always a line.

        Raises
        ------
        PalpateError
            If an expanded uncertainty is not finite.
        """
        errors, press = self.found.angle_errors()
        budget = self.budget or UncertaintyBudget((), 0.0, 0.0)
        if self.study is not None:
            noise = sum((line.contribution_deg**2 for line in budget.components if line.name == _NOISE), np.zeros(3))
            replaced = _SEATING if self.study.remounted else ""
            for name, term, known in (
                ("operator, day and mounting: gauge study", REPRODUCIBILITY, np.zeros(3)),
                ("repeatability beyond marker noise: gauge study", REPEATABILITY, noise),
            ):
                parts = [self.study.component(axis, term) for axis in ANGLES[:2]]
                axes = np.maximum([part.variance for part in parts], 0.0)
                sd = np.sqrt(np.maximum(np.append(axes, axes.mean()) - known, 0.0))
                dof = min((part.dof for part in parts if part.variance > 0), default=np.inf)
                budget = budget.with_line(name, sd, dof, without=replaced)
        excess = np.sqrt(np.maximum(np.mean(errors**2, axis=0) - budget.combined_deg**2, 0.0))
        if excess.any():
            name = "recorded errors" + (" beyond these lines" if budget.components else "")
            budget = budget.with_line(name, excess, max(len(np.unique(press)) - 1, 1))
        budget = replace(budget, normal_deg=max(budget.normal_deg, self._recorded_radius()))
        axis, total = self.found.reference.tilt_sd_deg(self.found.max_tilt_deg)
        budget = budget.with_line("reference standard", np.array([axis, axis, total]), kind="B")
        if not np.isfinite(budget.expanded_deg).all():
            raise PalpateError(
                f"The expanded uncertainties of a reading are {budget.expanded_deg}°.",
                "Correct the readings, the gauge study or the uncertainty of the reference.",
                code="uncertainty-not-finite",
            )
        return budget

    def _recorded_radius(self) -> float:
        """Return the 95.45 % quantile of the recorded angles between estimated and true normal, degrees."""
        read = np.isfinite(self.found.estimates).all(axis=1)
        true, estimated = (
            np.array([wall_normal(*np.radians(pose[:2])) for pose in each[read]])
            for each in (self.found.truth, self.found.estimates)
        )
        apart = np.degrees(np.linalg.norm(np.cross(true, estimated), axis=1))
        return float(np.quantile(apart, 0.9545))

    def not_covered(self) -> list[str]:
        """Return the conditions that the certificate does not cover."""
        found, change = self.found, self.found.reference.temperature_change
        low, high = np.nanmin(found.truth[:, 2]), np.nanmax(found.truth[:, 2])
        lines = [
            f"Total angles above {found.max_tilt_deg:.1f}°; depths outside {low:.1f} to {high:.1f} mm; obstacles "
            "other than a flat, rigid wall.",
            "Other images than those recorded, for the maximum errors: these are no bounds.",
            "Forces and friction.",
            "Ageing, wear, relaxation and contamination of the skin; no calibration interval is stated.",
            "Motion of the contact during an exposure; other light; other settings of the camera.",
            f"Temperatures that differ by more than {change:g} K from that of the rest image."
            if self.budget
            else "Other temperatures than those of the test.",
        ]
        if not found.reference.reference:
            lines.append("Traceability: no reference standard is stated, and its uncertainty is assumed.")
        if found.reference.temperature_c is None:
            lines.append("The temperature of the test, which is not stated.")
        if self.study is None:
            seated = "; seating has its tolerance only" if self.budget else ""
            lines.append(f"Operators, days and remounting: there is no gauge study{seated}.")
        elif self.study.absent:
            lines.append(f"Components that the gauge study does not determine: {', '.join(self.study.absent)}.")
        if self.study and not self.study.remounted:
            lines.append("Remounting: the gauge study has fewer than 4 degrees of freedom of mounting.")
        lines.append(
            "Type B evaluation of the unit: its estimator is not a twin."
            if self.budget is None
            else "Errors of the twin other than those of simulated units, unless the recorded errors show them."
        )
        return lines

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        budget = self.reading_budget()
        stated = {name: getattr(budget, name) for name in ("combined_deg", "dof", "factor", "expanded_deg")}
        return {
            "unit": self.title,
            **self.found.as_dict(),
            "files": dict(self.inputs),
            "uncertainty": {
                **{name: dict(zip(ANGLES, each.tolist(), strict=True)) for name, each in stated.items()},
                "normal_deg": budget.normal_deg,
                "largest_standard_deg": budget.largest_deg if self.budget else None,
                "lines": [line.as_dict() for line in budget.components],
            },
            "repeatability_deg": self.found.repeatability_deg(),
            "gauge_study": self.study.as_dict() if self.study else None,
            "not_covered": self.not_covered(),
        }

    def page(self, *signatures: str) -> list[str | Report]:
        """Return the report: result, inputs, method, uncertainty of a reading, signatures, budget and limits."""
        found, budget = self.found, self.reading_budget()
        table = []
        for score in found.scores:
            errors, paper = score.errors, PAPER_TABLE_3.get(score.component)
            of_paper = (paper.rmse, paper.mae, paper.max, paper.sd) if paper else ()
            values = [f"{value:.3f}" for value in vars(errors).values()]
            table.append((f"{score.component} {score.unit}", *values, " / ".join(f"{each:.2f}" for each in of_paper)))
        guard = "U is the guard band" if found.spec.guard else "Simple acceptance: the guard band is 0"
        study: list[str | Report] = []
        if self.study:
            title = f"## Gauge study of {self.study.readings} readings, against ± {found.spec.max_deg:g}°"
            study = [title, self.study.report(found.spec.max_deg)]
        return [
            f"# Certificate: {self.title}",
            f"**{self.verdict}**",
            Report.of("", _CHECKS, map(_row, found.checks)),
            f"Decision rule (ISO 14253-1): conformity is proven if figure + U ≤ tolerance. {guard}. U of a figure is "
            "that of the reference and, for an RMSE, of the sample of presses (upper limit by mean squares "
            "between and within presses). An RMSE of fewer than 5 presses is not decided.",
            *([] if found.reference.reference else [_UNSTATED]),
            Report.of("", ("component", "RMSE", "MAE", "max", "SD", "bias", _PAPER), table, details=[_PAPER]),
            "## Inputs",
            "\n".join(f"* {name}: {text}" for name, text in self.inputs.items()) or "* not stated",
            "The hash of several files is that of their contents in sequence, in the order of the table.",
            provenance_line(),
            "## Method, reference and environment",
            *self._basis(),
            "## Uncertainty of a reading in use (GUM, JCGM 100)",
            _expanded(budget),
            self._quoted(budget),
            *signatures,
            "## Uncertainty budget",
            budget.report(),
            "u(x) is the standard uncertainty of the quantity; c is the RMS sensitivity of the total angle"
            + (
                " over the range, by the twin. A line without u(x) combines several quantities."
                if self.budget
                else "."
            ),
            *study,
            "## Not covered",
            "\n".join(f"* {line}" for line in self.not_covered()),
        ]

    def _basis(self) -> list[str]:
        """Return sentences on method, reference and data."""
        found, stated = self.found, self.found.reference.temperature_c
        temperature = "not stated" if stated is None else f"{stated:g} °C"
        lines = [
            "Images of presses on a flat wall at reference angles were read by the estimator among the inputs. The "
            "error is the reading minus the reference. rx is roll, ry is pitch; the total angle is √(rx² + ry²).",
            f"{len(found.truth)} images of {len(np.unique(found.press))} presses, {found.spec.min_depth:g} mm deep "
            f"or more, up to {found.max_tilt_deg:.1f}°; {found.left_out} images left out; {found.flagged} of the "
            "evaluated readings are flagged.",
            f"Reference: {found.reference.describe(found.max_tilt_deg)}",
            f"Temperature: {temperature}"
            + (
                f"; the budget has a change of ± {found.reference.temperature_change:g} K since the rest image."
                if self.budget
                else "; its change is not evaluated."
            ),
        ]
        if found.zero:
            lines.append(
                f"The depth zero is at {found.zero.offset:.3f} mm on the robot's scale, by {found.zero.images} "
                "images of the first press, which is not evaluated."
            )
        if repeated := found.repeatability_deg():
            within, between = repeated
            lines.append(f"Errors of the total angle: SD {within:.3f}° within and {between:.3f}° between presses.")
        return lines

    def _quoted(self, budget: UncertaintyBudget) -> str:
        u, k = float(budget.combined_deg[-1]), float(budget.factor[-1])
        worst = f" (worst pose ± {k * budget.largest_deg:.3f}°)" if self.budget else ""
        return (
            f"Quoted for a reading in use: the total angle ± {k * u:.3f}°{worst}, with a coverage of nominally 95 % "
            "over the range, because it is the misalignment of the wall. The "
            f"direction of the wall normal is within {budget.normal_deg:.3f}° with the same coverage; 2 SD of a "
            f"two-dimensional error contain only 86 %. This radius also holds for total angles below {3.0 * u:.2f}° "
            "(3 u), which are not normally distributed (Rice)."
        )

    def write(self, folder: Path) -> None:
        """Write ``accept.json``, ``accept.md`` and ``accept.pdf`` into a folder.

        Raises
        ------
        PalpateError
            If they cannot be written.
        """
        write_report(folder, "accept", self.as_dict(), self.page())
        errors = self.found.estimates - self.found.truth
        known = errors[:, : 2 + np.isfinite(errors[:, 2]).any()]
        signed = [
            f"## Signatures; issued {datetime.now(UTC):%Y-%m-%d} (UTC)",
            *(f"{each}: {'_' * len(_FIELDS[0])}" for each in _FIELDS),
        ]
        with wrap_write_errors(folder, "Choose another folder."):
            write_pages(folder / "accept.pdf", self.page(*signed), self.found.truth, known)


def _expanded(budget: UncertaintyBudget) -> Report:
    columns = zip(ANGLES, budget.combined_deg, budget.dof, budget.factor, budget.expanded_deg, strict=True)
    rows = [
        (name, f"{u:.3f}", f"{dof:.0f}" if np.isfinite(dof) else "∞", f"{k:.2f}", f"{expanded:.3f}")
        for name, u, dof, k, expanded in columns
    ]
    rows.append(("angle between normals", "", "", "", f"{budget.normal_deg:.3f}"))
    return Report.of("", ("reading of", "u_c °", "ν_eff", "k", "U °"), rows)


def _row(check: AcceptanceCheck) -> tuple[str, str, str, str, str]:
    unit = "" if check.unit == "1" else f" {check.unit}"
    decision = check.decision if check.passed else check.decision.upper()
    return check.what, f"{check.value:.3f}{unit}", f"{check.expanded:.3f}{unit}", f"{check.limit:g}{unit}", decision
