"""Pictures of relaxation tests and their series."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from palpate.material.draw import POINTS
from palpate.material.fit_relaxation import RelaxationFit
from palpate.material.relaxation_history import relax_history
from palpate.material.relaxation_test import RelaxationTest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_INCH = (5.0, 3.8)
"""Size of the figure, inches."""
_SAMPLE, _MODEL = "0.55", "#c1272d"


def draw_relaxation(tests: Sequence[RelaxationTest], fit: RelaxationFit) -> Figure:
    """Draw the stress of every test, as shares of the instantaneous one, and the series, over log time.

    Parameters
    ----------
    tests
        As fitted.
    fit
        The fit.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # here, so that the front door opens fast
    from matplotlib.figure import Figure

    figure = Figure(figsize=_INCH, layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    for number, test in enumerate(tests):
        begun, whole = test.ramp_times
        since, course = test.strain_history
        answer = relax_history(fit.relaxation, since, course)[1:] / fit.relaxation.scale
        after = test.time >= begun
        time, stress = since[1:], test.stress[after]
        held = (test.time[after] >= whole) & (time > 0)
        axis.plot(
            time[held],
            stress[held] / np.mean(stress[held] / answer[held]),
            marker=".",
            markersize=3,
            linestyle="",
            color=_SAMPLE,
            label="measured" if number == 0 else None,
        )
    grid = np.geomspace(fit.first, fit.last, POINTS)
    axis.plot(
        grid,
        fit.relaxation.relaxation_function(grid),
        color=_MODEL,
        linewidth=1.8,
        label=f"{len(fit.relaxation.times)} terms",
    )
    axis.set_xscale("log")
    axis.set_xlabel("time since the strain began (s)")
    axis.set_ylabel("stress over the instantaneous")
    axis.legend(fontsize=8, frameon=False)
    return figure
