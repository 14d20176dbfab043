"""Report of an identified unit: posterior of its parameters, and the most informative next press."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from palpate.calibration import AccuracySpec, IdentificationResult, RobotUncertainty, rank_next_presses
from palpate.core import FloatArray, PalpateError, wrap_write_errors
from palpate.core.report import Report
from palpate.sensor.pose_estimator import TwinEstimator
from palpate.sensor.report import provenance_line, write_report
from palpate.sensor.sensor import Sensor

_KNOWN, _OPEN = 0.5, 0.9
"""Ratio of posterior to prior SD: maximum of an identified, minimum of an open parameter. By hand."""


def write_identification(folder: Path, found: IdentificationResult, sensor: Sensor, robot: RobotUncertainty) -> None:
    """Write ``identification.json``, ``.md`` and ``.png`` into a folder, which is created.

    `sensor` reads by the identified unit; `robot` is the uncertainty of further presses.

    Raises
    ------
    PalpateError
        If the sensor reads by a network, or the files cannot be written.
    """
    if not isinstance(sensor.estimator, TwinEstimator):
        raise PalpateError(
            "A network has no identified unit.", "Open the sensor with the design's twin.", code="network-no-unit"
        )
    fitter = sensor.estimator.fitter
    spec = AccuracySpec(
        noise_px=fitter.noise_px, robot=robot, max_tilt_deg=float(fitter.model.marker_twin.twin.tilts_deg[-1])
    )
    now, ranked = rank_next_presses(fitter.model, found.mounting, float(np.median(found.inverse_frictions)), spec)
    rows = found.rows(fitter.model.tolerance)
    content = {
        "known": rows,
        "misfit": found.misfit,
        "left_out": list(found.left_out),
        "error_by_unit_deg": now,
        "next": [press._asdict() for press in ranked],
    }
    write_report(folder, "identification", content, _page(rows, found, now, ranked))
    with wrap_write_errors(folder, "Choose another folder."):
        left = fitter.model.posterior.rest_px - fitter.model.camera.project(fitter.model.layout.positions)
        _draw(rows, fitter.model.posterior.rest_px, left).savefig(folder / "identification.png", dpi=120)


def _page(
    rows: list[dict[str, Any]], found: IdentificationResult, now: float, ranked: tuple[Any, ...]
) -> list[str | Report]:
    table = [
        (row["name"], row["unit"], f"{row['mean']:.4g}", f"{row['sd']:.2g}", f"{row['before']:.2g}", _word(row))
        for row in rows
    ]
    best, least = ranked[0], ranked[-1]
    still = ", ".join(row["name"] for row in rows if _word(row) == "open") or "nothing"
    return [
        "# An identified unit",
        f"The marker residual is {np.sqrt(found.misfit):.2f} times its expected value. Still open: {still}."
        + (f" Left out, as the twin has no derivative by it: {', '.join(found.left_out)}." if found.left_out else ""),
        Report.of(
            "", ("parameter", "unit", "mean", "standard deviation", "prior standard deviation", "result"), table
        ),
        "## Most informative next press",
        f"The remaining uncertainty of the unit contributes {now:.3f}° to rx and ry. A press at a tilt of "
        f"{best.tilt_deg:.1f}° in the direction {best.azimuth_deg:.0f}° would leave {best.rmse_deg:.3f}°; the "
        f"worst one ({least.tilt_deg:.1f}°, {least.azimuth_deg:.0f}°) {least.rmse_deg:.3f}°.",
        "![Prior and posterior of the parameters, and the rest markers against the design](identification.png)",
        provenance_line(),
    ]


def _word(row: dict[str, Any]) -> str:
    share = row["sd"] / row["before"] if row["before"] else 1.0
    return "identified" if share < _KNOWN else "open" if share > _OPEN else ""


def _draw(rows: list[dict[str, Any]], rest: FloatArray, left: FloatArray) -> Figure:
    """Draw posterior intervals in units of the prior, and the rest markers relative to the design."""
    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    bars, dots = figure.subplots(1, 2)
    shown = [row for row in rows if row["before"] > 0][::-1]
    at = np.arange(len(shown))
    bars.barh(at, [2.0] * len(shown), left=-1.0, color="#dddddd", label="prior (1 sd)")
    middle = np.array([(row["mean"] - (row["name"] == "stiffness")) / row["before"] for row in shown])
    middle -= np.array(["friction" in row["name"] for row in shown]) / np.array([row["before"] for row in shown])
    spread = np.array([row["sd"] / row["before"] for row in shown])
    bars.errorbar(middle, at, xerr=spread, fmt="o", ms=4, color="#00538c", label="posterior")
    bars.set_yticks(at, [row["name"] for row in shown], fontsize=8)
    bars.set(xlabel="deviation from the design, in prior standard deviations", title="Identified parameters")
    bars.legend(fontsize=8, loc="lower right")
    seen = np.isfinite(left).all(axis=1)
    shift = np.median(left[seen], axis=0)
    dots.plot(*rest[seen].T, ".", color="#00538c", ms=4)
    arrows = left[seen] - shift
    dots.quiver(*rest[seen].T, *arrows.T, angles="xy", color="#d1622b", width=0.003)
    dots.invert_yaxis()
    largest = float(np.linalg.norm(arrows, axis=1).max()) if seen.any() else 0.0
    dots.set(aspect="equal", xlabel="u, px", ylabel="v, px")
    dots.set_title(f"Rest markers against design and camera, longest arrow {largest:.2f} px", fontsize=10)
    return figure
