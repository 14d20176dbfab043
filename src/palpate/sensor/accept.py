"""Acceptance test of a built unit by recorded presses of known pose, with the figures of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from palpate.calibration import AccuracySpec, PoseFitter, UncertaintyBudget
from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, provenance
from palpate.sensor.depth_zero import DepthZero, find_depth_zero
from palpate.sensor.gauge_study import ANGLES
from palpate.sensor.recording import GroundTruth
from palpate.sensor.reference_standard import ReferenceSpec
from palpate.sensor.score import Score, score_errors, score_readings
from palpate.sensor.spec import AcceptanceSpec

PROVEN, OPEN, REFUTED = "conformity proven", "not decided", "non-conformity proven"
"""Decisions after ISO 14253-1, with the expanded uncertainty of a figure as guard band on both sides."""
WITHIN, OUTSIDE, SIMPLE = "within tolerance", "outside tolerance", "accepted (simple)"
"""Decisions without a stated reference standard, and simple acceptance of a figure."""
_DOUBT = 0.05
"""Allowance for the error of a determined depth zero, mm, so that images at the minimum depth count.
By hand."""


@dataclass(frozen=True)
class AcceptanceCheck:
    """Comparison of one figure, such as ``roll RMSE``, with its tolerance (`limit`).

    The `interval` is `None` for a figure without one. `expanded` is the expanded uncertainty U (k = 2) of the figure
    by the test: the reference standard and, for an RMSE, the sample of presses.
    """

    what: str
    unit: str
    value: float
    limit: float
    interval: tuple[float, float] | None
    expanded: float
    decision: str

    @property
    def passed(self) -> bool:
        """Whether figure + U (or, by simple acceptance, the figure) is within its tolerance."""
        return self.decision in (PROVEN, WITHIN, SIMPLE)


@dataclass(frozen=True, eq=False)
class Acceptance:
    """Result of an acceptance test.

    Attributes
    ----------
    spec, reference, checks
        Tolerances and settings, reference standard, and every figure with its tolerance.
    scores
        Roll, pitch, depth if it is known, and total angle.
    press, truth, estimates
        (n,), (n, 3), (n, 3) of the evaluated images, depth on the robot's scale.
    zero
        Zero of the depth, if it was determined.
    left_out, flagged
        Number of images below the minimum depth or of the press that gave the zero; number of evaluated images with a
        flagged reading.
    """

    spec: AcceptanceSpec
    reference: ReferenceSpec
    checks: tuple[AcceptanceCheck, ...]
    scores: tuple[Score, ...]
    press: IntArray
    truth: FloatArray
    estimates: FloatArray
    zero: DepthZero | None
    left_out: int
    flagged: int

    @property
    def passed(self) -> bool:
        """Whether every figure is within its tolerance."""
        return all(check.passed for check in self.checks)

    @property
    def max_tilt_deg(self) -> float:
        """Maximum total angle of the evaluated images, degrees."""
        return float(np.linalg.norm(self.truth[:, :2], axis=1).max())

    def angle_errors(self) -> tuple[FloatArray, IntArray]:
        """Return errors (n, 3) of rx, ry, total angle (degrees) and presses (n,), of images with a pose."""
        read = np.isfinite(self.estimates).all(axis=1)
        return _angle_errors(self.truth[read], self.estimates[read]), self.press[read]

    def budget(self, fitter: PoseFitter) -> UncertaintyBudget:
        """Compute the uncertainty budget of a unit that is read by its twin, over the range of the test.

        The range is at least 1°, because a total angle of zero has no direction.
        """
        spec = AccuracySpec(
            min_depth=self.spec.min_depth,
            max_tilt_deg=max(self.max_tilt_deg, 1.0),
            noise_px=fitter.noise_px,
            seed=self.spec.seed,
        )
        return UncertaintyBudget.of_unit(fitter.model, fitter.mounting, spec, self.reference.thermal)

    def repeatability_deg(self) -> tuple[float, float] | None:
        """Return SDs of the error of the total angle within and between presses; `None` without repetition.

        They are those of the one-way random-effects model (Searle, Casella & McCulloch, *Variance Components*, 1992).
        """
        errors, press = self.angle_errors()
        _, which, counts = np.unique(press, return_inverse=True, return_counts=True)
        error, images, presses = errors[:, -1], len(errors), len(counts)
        if not 1 < presses < images:
            return None
        means = np.bincount(which, error) / counts
        within = float(np.sum((error - means[which]) ** 2)) / (images - presses)
        squares = float(counts @ (means - error.mean()) ** 2) / (presses - 1)
        each = (images - counts @ counts / images) / (presses - 1)
        return float(np.sqrt(within)), float(np.sqrt(max((squares - within) / float(each), 0.0)))

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "passed": self.passed,
            "spec": self.spec.model_dump(mode="json"),
            "reference": self.reference.model_dump(mode="json"),
            "checks": [{**vars(check), "passed": check.passed} for check in self.checks],
            "scores": [score.as_dict() for score in self.scores],
            "images": len(self.truth),
            "presses": len(np.unique(self.press)),
            "zero_mm": self.zero.offset if self.zero else None,
            "left_out": self.left_out,
            "flagged": self.flagged,
            "made_by": provenance(),
        }


def accept_unit(
    truth: GroundTruth,
    estimates: FloatArray,
    flagged: BoolArray | None = None,
    spec: AcceptanceSpec | None = None,
    reference: ReferenceSpec | None = None,
) -> Acceptance:
    """Compare the readings of a unit with known poses.

    If the depth zero is determined, the first press gives it and is not evaluated.

    Parameters
    ----------
    truth
        Known poses.
    estimates
        (n, 3) rx, ry (degrees) and depth (mm) of the same images; NaN without a pose.
    flagged
        (n,) whether a reading is flagged.
    spec, reference
        Tolerances, and reference standard of the known poses.

    Raises
    ------
    PalpateError
        If no image can be evaluated, or the first press does not give the zero.
    """
    spec, reference = spec or AcceptanceSpec(), reference or ReferenceSpec()
    flagged = np.zeros(len(estimates), bool) if flagged is None else flagged
    known = bool(np.isfinite(truth.poses[:, 2]).all())
    zero, counts = None, np.ones(len(estimates), bool)
    if spec.zero and known:
        first = truth.press == 0
        try:
            zero = find_depth_zero(estimates[first, 2], truth.poses[first, 2], spec.min_depth)
        except PalpateError as error:
            raise PalpateError(
                f"Too few images of the first press are deeper than {spec.min_depth:g} mm to give the depth zero.",
                "Use the depths of the table (`--no-zero`), lower `--min-depth`, or record a deeper first press.",
                code="depth-zero-unknown",
            ) from error
        counts &= ~first
    offset = zero.offset if zero else 0.0
    # an image without a pose counts if the truth says that it is deep enough
    depth = truth.poses[:, 2] - offset if known else estimates[:, 2]
    counts &= ~(depth < spec.min_depth - (_DOUBT if zero else 1e-9))
    if not counts.any():
        raise PalpateError(
            f"No image is deeper than {spec.min_depth:g} mm after the first press.",
            "Record more presses, or press deeper.",
            code="acceptance-no-press",
        )
    read = estimates[counts] + np.array([0.0, 0.0, offset])
    wanted = truth.poses[counts] if known else np.column_stack([truth.poses[counts, :2], read[:, 2]])
    kept = 3 if known else 2
    scores = score_readings(wanted, read, truth.press[counts], spec.seed)[:kept]
    posed = np.isfinite(read).all(axis=1)
    total = _angle_errors(wanted[posed], read[posed])[:, -1]
    scores += (score_errors(ANGLES[-1], "deg", total, truth.press[counts][posed], spec.seed),)
    errors = np.column_stack([(read - wanted)[posed, :kept], total])
    limits = [_rmse_limit(each, truth.press[counts][posed]) for each in errors.T]
    axis, along = reference.tilt_sd_deg(float(np.linalg.norm(wanted[:, :2], axis=1).max()))
    sd = [*[axis, axis, reference.reference_depth][:kept], along]
    return Acceptance(
        spec=spec,
        reference=reference,
        checks=tuple(_check(scores, limits, sd, spec, bool(reference.reference), float((~posed).mean()))),
        scores=scores,
        press=truth.press[counts],
        truth=wanted,
        estimates=read,
        zero=zero,
        left_out=int((~counts).sum()),
        flagged=int(flagged[counts].sum()),
    )


def _angle_errors(truth: FloatArray, read: FloatArray) -> FloatArray:
    """Return errors (n, 3) of rx, ry and the total angle, degrees."""
    total = np.linalg.norm(read[:, :2], axis=1) - np.linalg.norm(truth[:, :2], axis=1)
    return np.column_stack([(read - truth)[:, :2], total])


def _check(
    scores: tuple[Score, ...],
    limits: list[float],
    sd: list[float],
    spec: AcceptanceSpec,
    stated: bool,
    without: float,
) -> list[AcceptanceCheck]:
    """Compare scores, upper limits of RMSE, and standard uncertainties of the reference with tolerances."""
    checks = []

    def add(
        what: str,
        unit: str,
        value: float,
        limit: float,
        expanded: float,
        interval: tuple[float, float] | None = None,
    ) -> None:
        within, outside = value + expanded <= limit, value - expanded > limit
        if not (within or outside) or (interval and scores[0].presses < 5):
            decision = SIMPLE if value <= limit and not spec.guard else OPEN
        elif stated:
            decision = PROVEN if within else REFUTED
        else:
            decision = WITHIN if within else OUTSIDE
        checks.append(AcceptanceCheck(what, unit, value, limit, interval, float(expanded), decision))

    for score, upper, standard in zip(scores, limits, sd, strict=True):
        angle, rmse, expanded = score.unit == "deg", score.errors.rmse, 2.0 * standard
        both = float(np.hypot(expanded, upper - rmse))
        limit = spec.rmse_deg if angle else spec.depth_rmse
        add(f"{score.component} RMSE", score.unit, rmse, limit, both, score.rmse_interval)
        if angle:
            add(f"{score.component} maximum error", score.unit, score.errors.max, spec.max_deg, expanded)
    add("images without a pose", "1", without, spec.without_pose, 0.0)
    return checks


def _rmse_limit(error: FloatArray, press: IntArray) -> float:
    """Return the upper limit (one-sided, k = 2) of the RMSE of errors (n,) of presses (n,).

    The square is the sum of the shares between and within presses. Its limit is that of Graybill and Wang (modified
    large sample; Burdick and Graybill, *Confidence Intervals on Variance Components*, 1992). A bias counts as
    variance between presses.
    """
    _, which, counts = np.unique(press, return_inverse=True, return_counts=True)
    between = float(np.sum(np.bincount(which, error) ** 2 / counts))
    shares = np.array([between, float(np.sum(error**2)) - between]) / len(error)
    dof = np.array([len(counts), max(len(error) - len(counts), 1)])
    wider = dof / stats.chi2.ppf(stats.norm.sf(2.0), dof) - 1.0
    return float(np.sqrt(shares.sum() + np.linalg.norm(shares * wider)))
