"""Acceptance test of a built unit by recorded presses of known pose, with the figures of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, provenance
from palpate.sensor.depth_zero import DepthZero, find_depth_zero
from palpate.sensor.recording import GroundTruth
from palpate.sensor.score import COMPONENTS, Score, score_readings
from palpate.sensor.spec import AcceptanceSpec

_DOUBT = 0.05
"""Allowance for the error of a determined depth zero, mm, so that images at the minimum depth count.
By hand."""


@dataclass(frozen=True)
class AcceptanceCheck:
    """Comparison of one figure, such as ``roll RMSE``, with its tolerance (`limit`).

    The `interval` is `None` for a figure without one; `passed` is whether the figure is within its tolerance.
    """

    what: str
    unit: str
    value: float
    limit: float
    interval: tuple[float, float] | None
    passed: bool


@dataclass(frozen=True, eq=False)
class Acceptance:
    """Result of an acceptance test.

    Attributes
    ----------
    spec, checks
        Tolerances and settings, and every figure with its tolerance.
    scores
        Roll, pitch and, if it is known, depth.
    press, truth, estimates
        (n,), (n, 3), (n, 3) of the evaluated images, depth on the robot's scale.
    zero
        Zero of the depth, if it was determined.
    left_out, flagged
        Number of images below the minimum depth or of the press that gave the zero; number of evaluated images with a
        flagged reading.
    """

    spec: AcceptanceSpec
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

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "passed": self.passed,
            "spec": self.spec.model_dump(mode="json"),
            "checks": [vars(check) for check in self.checks],
            "scores": [score.as_dict() for score in self.scores],
            "images": len(self.truth),
            "presses": len(np.unique(self.press)),
            "zero_mm": self.zero.offset if self.zero else None,
            "left_out": self.left_out,
            "flagged": self.flagged,
            "made_by": provenance(),
        }


def accept_unit(
    truth: GroundTruth, estimates: FloatArray, flagged: BoolArray | None = None, spec: AcceptanceSpec | None = None
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
    spec
        Tolerances.

    Raises
    ------
    PalpateError
        If no image can be evaluated, or the first press does not give the zero.
    """
    spec = spec or AcceptanceSpec()
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
    scores = score_readings(wanted, read, truth.press[counts], spec.seed)[: 3 if known else 2]
    return Acceptance(
        spec=spec,
        checks=tuple(_check(scores, spec, float((~np.isfinite(read).all(axis=1)).mean()))),
        scores=scores,
        press=truth.press[counts],
        truth=wanted,
        estimates=read,
        zero=zero,
        left_out=int((~counts).sum()),
        flagged=int(flagged[counts].sum()),
    )


def _check(scores: tuple[Score, ...], spec: AcceptanceSpec, without: float) -> list[AcceptanceCheck]:
    limits = (spec.rmse_deg, spec.rmse_deg, spec.depth_rmse)
    checks = []
    for score, limit, (name, unit) in zip(scores, limits, COMPONENTS, strict=False):
        judged = score.rmse_interval[1] if spec.guard else score.errors.rmse
        checks.append(
            AcceptanceCheck(f"{name} RMSE", unit, score.errors.rmse, limit, score.rmse_interval, judged <= limit)
        )
        if unit == "deg":
            most = score.errors.max
            checks.append(
                AcceptanceCheck(f"{name} maximum error", unit, most, spec.max_deg, None, most <= spec.max_deg)
            )
    checks.append(
        AcceptanceCheck("images without a pose", "1", without, spec.without_pose, None, without <= spec.without_pose)
    )
    return checks
