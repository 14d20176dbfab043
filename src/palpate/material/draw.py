"""Figures of tests and fits: samples, mean and model, one panel a test (as in the paper's Fig. 8)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from palpate.core import PalpateError, wrap_write_errors
from palpate.material.fit import Fit
from palpate.material.prepare import average_samples
from palpate.material.sample import Loading, Sample

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL_INCH = (4.4, 3.6)
"""Size of a panel, inches."""
DOTS_PER_INCH = 160
"""Resolution of a figure."""
POINTS = 200
"""Points of a drawn curve."""
_SAMPLE, _MEAN, _MODEL = "0.55", "black", "#c1272d"


def draw_fit(samples: Sequence[Sample], fit: Fit, title: str = "") -> Figure:
    """Draw every sample, the mean with its spread, and the fitted model, one panel a test.

    Parameters
    ----------
    samples
        As fitted.
    fit
        The fit.
    title
        Above the panels.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # here, so that the front door opens fast
    from matplotlib.figure import Figure

    loadings = [loading for loading in Loading if any(sample.loading is loading for sample in samples)]
    figure = Figure(figsize=(PANEL_INCH[0] * len(loadings), PANEL_INCH[1] + 0.35), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, len(loadings), squeeze=False)[0]
    greatest = max(float(np.abs(sample.nominal).max()) for sample in samples)
    unit, scale = ("MPa", 1.0) if greatest >= 1 else ("kPa", 1e3)
    for axis, loading in zip(axes, loadings, strict=True):
        chosen = [sample for sample in samples if sample.loading is loading]
        _draw_panel(axis, chosen, fit, scale)
        axis.set_title(str(loading), fontsize=10)
        axis.set_xlabel("stretch")
        axis.set_ylabel(f"nominal stress ({unit})")
    constants = ", ".join(f"{name} = {value:.4g}" for name, value in fit.constants.items())
    figure.suptitle((f"{title}\n" if title else "") + f"{fit.model.name}: {constants} (MPa)", fontsize=10)
    return figure


def save_figure(path: Path, figure: Figure) -> None:
    """Write a figure as PNG, SVG or PDF, by its ending.

    Raises
    ------
    PalpateError
        If the ending is unknown or the file cannot be written.
    """
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise PalpateError(
            f"{path} does not end in .png, .svg or .pdf.", "Name the picture so.", code="file-ending-unknown"
        )
    with wrap_write_errors(path, "Name a file in an existing folder."):
        figure.savefig(path, dpi=DOTS_PER_INCH)


def _draw_panel(axis: Axes, samples: Sequence[Sample], fit: Fit, scale: float) -> None:
    low = min(float(sample.stretch.min()) for sample in samples)
    high = max(float(sample.stretch.max()) for sample in samples)
    for at, sample in enumerate(samples):
        several = f"{len(samples)} samples" if len(samples) > 1 else "sample"
        few = len(sample.stretch) < 60
        axis.plot(
            sample.stretch,
            scale * sample.nominal,
            marker="o" if few else "",
            markersize=3,
            linestyle="" if few and len(samples) == 1 else "-",
            color=_SAMPLE,
            linewidth=0.8,
            label=several if at == 0 else None,
        )
    if len(samples) > 1:
        mean = average_samples(samples)
        band = (scale * (mean.mean - mean.spread), scale * (mean.mean + mean.spread))
        axis.fill_between(mean.stretch, *band, color=_MEAN, alpha=0.15, linewidth=0, label="± one deviation")
        axis.plot(mean.stretch, scale * mean.mean, color=_MEAN, linestyle="--", linewidth=1.1, zorder=4, label="mean")
    grid = np.linspace(min(low, 1.0), max(high, 1.0), POINTS)
    axis.plot(grid, scale * fit.nominal(samples[0].mode, grid), color=_MODEL, linewidth=1.8, label=fit.model.name)
    axis.axhline(0, color="0.8", linewidth=0.6, zorder=0)
    axis.legend(fontsize=8, frameon=False)
