"""Figure of a convergence study, as the paper's Fig. 9."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from palpate.fea.convergence import MeshResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PAPER_LIMIT = 5.0
"""Deviation in percent below which the paper calls its maximum stress converged."""


def plot_convergence(results: Sequence[MeshResult]) -> Figure:
    """Draw the maximum stress and the errors of stress, force and markers against the number of elements.

    `results` are those of at least two meshes, from the coarsest to the finest.
    """
    from matplotlib.figure import Figure  # here, because matplotlib is slow to load
    from matplotlib.ticker import LogLocator

    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    stress, errors = figure.subplots(1, 2)
    elements = [result.elements for result in results]
    stress.plot(elements, [result.peak_stress for result in results], "o-", color="C0")
    stress.set_ylabel("maximum von Mises stress (MPa)")
    stress.set_ylim(0, 1.15 * max(result.peak_stress for result in results))
    coarser = results[:-1]
    curves = {
        "maximum stress": [100 * abs(result.stress_error) for result in coarser],
        "force": [100 * abs(result.force_error) for result in coarser],
        "markers, rms over depth": [100 * result.marker_error for result in coarser],
    }
    for (name, values), mark in zip(curves.items(), "os^", strict=True):
        errors.plot(elements[:-1], values, f"{mark}-", label=name)
    errors.axhline(_PAPER_LIMIT, color="0.5", linestyle="--", linewidth=1, label=f"{_PAPER_LIMIT:g} %")
    errors.set_yscale("log", subs=[])
    errors.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    errors.yaxis.set_major_formatter("{x:g}")
    errors.set_ylabel("deviation from the finest mesh (%)")
    errors.legend(frameon=False, fontsize=8, ncols=2, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    for axis in (stress, errors):
        _label_elements(axis, elements)
    figure.suptitle(f"{results[-1].depth:.3g} mm deep, finest mesh {results[-1].elements} elements", fontsize=11)
    return figure


def _label_elements(axis: Axes, elements: Sequence[int]) -> None:
    axis.set_xscale("log")
    axis.set_xticks(elements, [str(count) for count in elements])
    axis.set_xticks([], minor=True)
    axis.set_xlim(0.8 * elements[0], 1.25 * elements[-1])
    axis.set_xlabel("elements of the modelled part")
    axis.spines[["top", "right"]].set_visible(False)
