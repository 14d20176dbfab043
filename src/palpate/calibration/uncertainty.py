"""Uncertainty budget of a reading after the GUM (JCGM 100:2008), with sensitivities from the twin.

The error of rx and ry is linear in independent inputs x_i (`pose_gain`), so that

    V(rx, ry) = Σ c_i c_iᵀ u²(x_i),    u²(θ) = gᵀ V g,    θ = √(rx² + ry²),    g = (rx, ry) / θ.

The unit is read after its rest image. With A the derivative of the rest markers by camera and print, P the prior
information, σ the spread of a marker and K = (AᵀA/σ² + P)⁻¹ Aᵀ/σ², the remaining error of the camera is

    δ = (I − K A) x − K w,    w: misprint of each marker,

so that each tolerance has its own, uncorrelated line. The parameters of an identified unit are correlated; they are
one line. Lines are RMS values over the working range (`sample_working_range`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy import linalg, stats

from palpate.calibration.deviation import IMPERFECTIONS
from palpate.calibration.fit_pose import twin_sd
from palpate.calibration.mounting import MOUNTING_PARAMETERS, Mounting, mounting_prior_sd, prior_mounting
from palpate.calibration.predict_accuracy import AccuracySpec, pose_gain, sample_working_range
from palpate.calibration.tolerance import ToleranceSpec
from palpate.calibration.twin_error import ValidationPresses, measure_twin_error
from palpate.calibration.unit_model import (
    CAMERA_PARAMETERS,
    PRINT_SHIFT,
    UNIT_PARAMETERS,
    UnitModel,
    build_unit_model,
    infer_from_rest,
    rest_jacobian,
    unit_prior_sd,
)
from palpate.camera import Camera
from palpate.core import FloatArray, generator
from palpate.core.report import Report
from palpate.core.state import State
from palpate.design import TILT_SPACE, MarkerLayout
from palpate.surrogate import Twin

_COVERAGE = float(stats.chi2.cdf(2.0**2, 1))
"""Coverage probability of k = 2 for a normal distribution, 0.9545."""
_MEASURANDS = ("rx", "ry", "total angle")
_THERMAL = ("change_k", "focal_per_k", "holder_per_k", "skin_per_k", "modulus_per_k")
_NORMAL, _UNIFORM = "normal", "uniform"


class UncertaintyComponent(NamedTuple):
    """One line of a budget: a quantity, and the type of its evaluation (``A`` or ``B``).

    `standard` is the standard uncertainty of the quantity in its `unit`; `None` for several quantities of different
    units. `contribution_deg` (3,) are the standard uncertainties of rx, ry and total angle by it.
    """

    name: str
    kind: str
    distribution: str
    unit: str = ""
    standard: float | None = None
    contribution_deg: FloatArray = np.zeros(len(_MEASURANDS))
    dof: float = np.inf

    @property
    def sensitivity(self) -> float | None:
        """RMS sensitivity of the total angle, degrees per unit of the quantity."""
        return float(self.contribution_deg[-1]) / self.standard if self.standard else None

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self._asdict(),
            "sensitivity": self.sensitivity,
            "contribution_deg": dict(zip(_MEASURANDS, self.contribution_deg.tolist(), strict=True)),
        }


@dataclass(frozen=True, eq=False)
class UncertaintyBudget:
    """Uncertainty budget of a reading.

    Attributes
    ----------
    components
        Lines, in descending order of the total angle.
    largest_deg
        Standard uncertainty of the total angle at the worst sampled pose, degrees.
    normal_deg
        95.45 % radius of the angle between estimated and true wall normal, degrees.
    """

    components: tuple[UncertaintyComponent, ...]
    largest_deg: float
    normal_deg: float

    @property
    def combined_deg(self) -> FloatArray:
        """(3,) combined standard uncertainties of rx, ry and total angle, degrees."""
        squares = (line.contribution_deg**2 for line in self.components)
        return np.asarray(np.sqrt(sum(squares, np.zeros(len(_MEASURANDS)))), float)

    @property
    def dof(self) -> FloatArray:
        """(3,) effective degrees of freedom by Welch and Satterthwaite (GUM, eq. G.2b)."""
        rest = sum((line.contribution_deg**4 / line.dof for line in self.components), np.zeros(len(_MEASURANDS)))
        return np.divide(self.combined_deg**4, rest, out=np.full(len(_MEASURANDS), np.inf), where=rest > 0)

    @property
    def factor(self) -> FloatArray:
        """(3,) coverage factors: 2, more for few degrees of freedom (GUM, G.6.4)."""
        return np.asarray(stats.t.ppf(0.5 + 0.5 * _COVERAGE, self.dof), float)

    @property
    def expanded_deg(self) -> FloatArray:
        """(3,) expanded uncertainties of rx, ry and total angle, degrees."""
        return self.factor * self.combined_deg

    @classmethod
    def of_design(
        cls, twin: Twin, layout: MarkerLayout, camera: Camera, tolerance: ToleranceSpec, spec: AccuracySpec
    ) -> UncertaintyBudget:
        """Predict the budget of built units of a design; arguments as for `predict_accuracy`."""
        rest = camera.project(layout.positions)
        belief = infer_from_rest(twin, layout, camera.spec, rest, tolerance, spec.noise_px)
        belief = replace(belief, mean=State.zeros(UNIT_PARAMETERS))
        return cls.of_unit(build_unit_model(twin, layout, belief, tolerance), None, spec)

    @classmethod
    def of_unit(
        cls,
        model: UnitModel,
        mounting: Mounting | None,
        spec: AccuracySpec,
        thermal: State | None = None,
        validation_presses: Sequence[ValidationPresses] = (),
    ) -> UncertaintyBudget:
        """Compute the budget of the readings of a unit.

        Parameters
        ----------
        model
            The unit after its rest image, or as identified.
        mounting
            Mounting of an identified unit; `None` if it was not identified.
        spec
            Working range, noise, number of poses, and seed; calibration presses are ignored.
        thermal
            Half-width of the temperature's change since the rest image (K), and relative changes per kelvin of the
            image distance, the camera's holder, the skin and its modulus; no change by default. The modulus has no
            effect, because the motion of the wall is prescribed.
        validation_presses
            Presses by which the error of the twin is measured (`measure_twin_error`); `twin_sd` without any. It is
            along the tilt, since a press is symmetric to the plane of its tilt.
        """
        thermal, tolerance, twin = thermal or State.zeros(_THERMAL), model.tolerance, model.marker_twin.twin
        known, change = mounting or prior_mounting(model.posterior, tolerance), thermal["change_k"] / np.sqrt(3.0)
        spread = np.asarray(np.linalg.cholesky(known.covariance + 1e-15 * np.eye(len(known.covariance))), float)
        softer = float(np.hypot(tolerance.modulus / np.sqrt(3.0), thermal["modulus_per_k"] * change))
        inputs = [(UncertaintyComponent("unit and mounting, identified", "A, B", _NORMAL), spread)]
        inputs = inputs if mounting else _remaining(model, spec.noise_px)
        stiffness = UncertaintyComponent("stiffness of the skin", "B", _UNIFORM, "1", softer)
        inputs.append((stiffness, np.zeros((len(spread), 1))))
        assumed = twin_sd(twin.skin)[TILT_SPACE.names]
        measured = measure_twin_error(model, validation_presses, 0, spec.min_depth) if validation_presses else None
        distance = thermal["holder_per_k"] * model.posterior.nominal.distance
        warmer = model.posterior.camera(focal=thermal["focal_per_k"], distance=distance)
        lines = [line for line, _ in inputs]
        lines += [
            UncertaintyComponent("marker noise, of the image and at rest", "B", _NORMAL, "px", spec.noise_px),
            UncertaintyComponent("temperature", "B", _UNIFORM, "K", change),
            UncertaintyComponent("error of the twin", "B", _NORMAL),
        ]
        if moving := bool(tolerance.lateral or tolerance.twist_deg or tolerance.curvature):
            lines.append(UncertaintyComponent("lateral motion and curvature of the wall", "B", _NORMAL))
        squares, directions = [], []
        for pose, friction in sample_working_range(twin, spec, tolerance, generator(spec.seed, "budget", "poses")):
            uphill, off = pose[:2] / np.linalg.norm(pose[:2]), assumed if measured is None else measured.at(pose)
            gain = pose_gain(model, known, spread, pose, friction, spec.noise_px)
            by_unit = np.linalg.solve(spread.T, gain.unit_gain.T).T[:2]
            noise = spec.noise_px**2 * gain.marker_gain[:2] @ gain.marker_gain[:2].T
            moved = model.marker_twin.evaluate(pose, friction, model.posterior.mean["thickness"], None).positions
            shift = warmer.project(moved * (1.0 + thermal["skin_per_k"])) - model.camera.project(moved)
            warm = change * gain.marker_gain[:2] @ shift[model.visible].reshape(-1)
            parts = [by_unit @ root @ root.T @ by_unit.T for _, root in inputs]
            parts += [2.0 * noise, np.outer(warm, warm), np.outer(uphill, uphill) * (off[:2] @ off[:2])]
            if moving:
                parts.append(gain.image_covariance[:2, :2] - noise - np.diag(assumed[:2] ** 2))
            squares.append(parts)
            directions.append([*np.eye(2), uphill])
        variances = np.einsum("pai,pkij,paj->kpa", directions, squares, directions)
        contributions = np.sqrt(np.maximum(variances.mean(axis=1), 0.0))
        lines = [line._replace(contribution_deg=each) for line, each in zip(lines, contributions, strict=True)]
        drawn = generator(spec.seed, "budget", "normals").standard_normal((spec.units, len(squares), 2))
        errors = np.einsum("pij,upj->upi", np.linalg.cholesky(np.sum(squares, axis=1)), drawn)
        radius = float(np.quantile(np.linalg.norm(errors, axis=-1), _COVERAGE))
        return cls(_sorted(lines), float(np.sqrt(variances.sum(axis=0)[:, -1].max())), radius)

    def with_line(
        self, name: str, contribution_deg: FloatArray, dof: float = np.inf, *, kind: str = "A", without: str = ""
    ) -> UncertaintyBudget:
        """Return the budget with a line (3,) of a type; `without` is the name of a line that is replaced.

        The worst pose changes in proportion. The square of the radius of the normal changes by that of an isotropic
        error with the largest change of variance of rx, ry and total angle.
        """
        kept = [line for line in self.components if line.name != without]
        sd = float(contribution_deg[-1])
        kept.append(UncertaintyComponent(name, kind, _NORMAL, "°", sd or None, contribution_deg, dof))
        found = replace(self, components=_sorted(kept))
        before, after = self.combined_deg, found.combined_deg
        ratio = float(after[-1] / before[-1]) if before[-1] else 1.0
        square = self.normal_deg**2 + float(stats.chi2.ppf(_COVERAGE, 2) * (after**2 - before**2).max())
        normal = max(np.sqrt(max(square, 0.0)), 2.0 * after.max())
        return replace(found, largest_deg=ratio * self.largest_deg, normal_deg=float(normal))

    def report(self) -> Report:
        """Return the table of the lines."""
        rows = []
        for line in self.components:
            standard = "" if line.standard is None else f"{line.standard:.2g} {line.unit}".removesuffix(" 1")
            sensitivity = "" if line.sensitivity is None else f"{line.sensitivity:.2g}"
            dof = f"{line.dof:.0f}" if np.isfinite(line.dof) else "∞"
            parts = [f"{value:.4f}" for value in line.contribution_deg]
            rows.append((line.name, line.kind, line.distribution, standard, sensitivity, *parts, dof))
        rows.append(("combined", "", "", "", "", *[f"{value:.4f}" for value in self.combined_deg], ""))
        heads = ("quantity", "type", "distribution", "u(x)", "|c| °/unit", "u(rx) °", "u(ry) °", "u(total) °", "ν")
        return Report.of("", heads, rows, details=heads[1:3])


def _sorted(lines: Sequence[UncertaintyComponent]) -> tuple[UncertaintyComponent, ...]:
    return tuple(sorted(lines, key=lambda line: -line.contribution_deg[-1]))


def _remaining(model: UnitModel, noise_px: float) -> list[tuple[UncertaintyComponent, FloatArray]]:
    """Return a line for each tolerance, and a root (15, n) of its covariance after the rest image."""
    tolerance, camera = model.tolerance, len(CAMERA_PARAMETERS)
    by_rest, spread = rest_jacobian(
        model.marker_twin.twin, model.layout, model.posterior.camera(), tolerance, noise_px
    )
    slopes = by_rest[model.visible].reshape(-1, camera + len(PRINT_SHIFT))
    sd = np.concatenate(
        [
            unit_prior_sd(tolerance)[:camera],
            np.full(len(PRINT_SHIFT), max(tolerance.print_shift, 1e-6) / np.sqrt(3.0)),
        ]
    )
    answer = np.linalg.solve(slopes.T @ slopes / spread**2 + np.diag(sd**-2.0), slopes.T / spread**2)[:camera]
    left = np.eye(camera, len(sd)) - answer @ slopes
    names = (*CAMERA_PARAMETERS, *PRINT_SHIFT, *UNIT_PARAMETERS[camera:], *MOUNTING_PARAMETERS)
    others = np.diag([*unit_prior_sd(tolerance)[camera:], *mounting_prior_sd(tolerance)])
    roots = linalg.block_diag(left * sd, others)
    misprint = np.pad(spread * answer, ((0, len(others)), (0, 0)))
    lines = []
    for item in IMPERFECTIONS:
        printed, sd_of = item.name == "marker_position", float(getattr(tolerance, item.name)) / np.sqrt(3.0)
        root = misprint if printed else roots[:, np.isin(names, item.parts)]
        if printed or (root.size and sd_of):
            lines.append((UncertaintyComponent(item.label, "B", _UNIFORM, item.unit, sd_of), root))
    return lines
