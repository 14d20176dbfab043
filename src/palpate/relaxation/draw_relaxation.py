"""Pictures of relaxation tests and their series."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from palpate.relaxation.fit_relaxation import RelaxationFit
from palpate.relaxation.held_test import RelaxationTest
from palpate.relaxation.history import relax_history

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_INCH = (5.0, 3.8)
_POINTS = 200
_SAMPLE, _MODEL = "0.55", "#c1272d"


def draw_relaxation(tests: Sequence[RelaxationTest], fit: RelaxationFit) -> Figure:
    """Draw the stress of every test over that of its series at its end, and the series, over log time.

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
        begun, whole = test.came
        course = np.interp(test.time, [begun, max(whole, begun + 1e-12)], [0.0, 1.0])
        if test.strain is not None:
            course = test.strain / np.median(test.strain[len(test.strain) // 2 :])
        answer = relax_history(fit.relaxation, test.time, course if whole > begun else np.ones(len(test.time)))
        if whole == begun:
            answer = fit.relaxation.modulus(test.time - begun)
        held = test.time >= max(whole, np.nextafter(begun, np.inf))
        size = float(np.mean(test.stress[held] / answer[held])) * fit.relaxation.scale
        axis.plot(
            test.time[held] - begun,
            test.stress[held] / size,
            marker=".",
            markersize=3,
            linestyle="",
            color=_SAMPLE,
            label="measured" if number == 0 else None,
        )
    grid = np.geomspace(fit.first, fit.last, _POINTS)
    axis.plot(
        grid, fit.relaxation.left(grid), color=_MODEL, linewidth=1.8, label=f"{len(fit.relaxation.times)} terms"
    )
    axis.set_xscale("log")
    axis.set_xlabel("time since the strain began (s)")
    axis.set_ylabel("stress over the instantaneous")
    axis.legend(fontsize=8, frameon=False)
    return figure
