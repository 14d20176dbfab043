"""Figures of a search: progress, front, and winning design."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from palpate.camera import CameraSpec, build_camera, marker_outlines, render
from palpate.design import MarkerLayout, Skin, place_markers, place_orientation_mark
from palpate.optimise.front import DesignCandidate, Front, SkinTrial, coarse_errors, find_best

UNITS = {"error": "deg", "force": "N", "markers": "", "price": "", "size": "mm"}
"""Units of the objectives."""
_BLUE, _GREY, _RED, _GREEN, _ORANGE = "#1864ab", "#adb5bd", "#c92a2a", "#2b8a3e", "#e67700"
_SILICONE, _CAMERA = "#e8c9a8", "#343a40"


def draw_search(front: Front) -> Figure:
    """Draw the minimum error so far over the skins tried, with random search and grid as baselines."""
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axis, most, control = figure.add_subplot(), front.spec.markers, front.search_baselines
    for meets, colour, words in ((True, _BLUE, "meets the limits"), (False, _GREY, "does not")):
        if found := coarse_errors(front.trials, most, meets=meets):
            axis.plot(*np.array(found).T, "o", ms=4, color=colour, label=words)
    _step(axis, front.trials, most, _BLUE, "minimum so far")
    _step(axis, control.random, most, _ORANGE, "minimum of random search")
    rival = find_best(control.grid, most)
    if rival is not None:
        words = f"best of the grid: {rival.trial.coarse.skin.build().name}, {rival.option.markers.count} markers"
        axis.axhline(rival.value("error"), color=_GREEN, lw=1.0, ls="-.", label=words)
    axis.set(xlabel="skins tried", ylabel="95th-percentile error over units, deg")
    _plain_logarithm(axis)
    shown = axis.get_ylim()  # by what was found: what is wanted can be far above all of it
    axis.axhline(front.spec.error_deg, color=_RED, lw=0.8, ls="--", label=f"wanted: {front.spec.error_deg:g}°")
    axis.set_ylim(shown)
    axis.legend(fontsize="small")
    return figure


def _step(axis: Axes, skins: Sequence[SkinTrial], markers: int, colour: str, words: str) -> None:
    """Draw the minimum error so far of feasible skins, up to the last skin."""
    if found := coarse_errors(skins, markers, meets=True):
        numbers, errors = np.array([*found, (skins[-1].number, np.inf)]).T
        axis.step(numbers, np.minimum.accumulate(errors), where="post", color=colour, label=words)


def draw_front(front: Front) -> Figure:
    """Draw the front over its first two objectives, or over the number of markers for one objective."""
    names = front.spec.objectives if len(front.spec.objectives) > 1 else (*front.spec.objectives, "markers")
    first, second = (name if name != names[0] or k == 0 else "error" for k, name in enumerate(names[:2]))
    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axis = figure.add_subplot()
    for entries, style, colour, words in (
        (front.feasible, ".", _GREY, "every design that meets the limits"),
        (front.coarse_pareto, "s", _ORANGE, "front, coarse presses only"),
        (front.pareto, "o", _BLUE, "front"),
    ):
        if entries:
            places = [(entry.value(second), entry.value(first)) for entry in entries]
            axis.plot(*np.array(places).T, style, color=colour, label=words)
    if second != "markers":
        _write_dots(axis, front.pareto, second, first)
    if front.baseline is not None and first == "error":
        words = f"baseline, predicted: {front.baseline.p95_deg:.3f}°"
        axis.axhline(front.baseline.p95_deg, color=_GREEN, lw=1.0, ls="-.", label=words)
    axis.set(xlabel=_label(second), ylabel=_label(first))
    axis.margins(x=0.12)
    _plain_logarithm(axis)
    if axis.get_legend_handles_labels()[0]:
        axis.legend(fontsize="small")
    return figure


def _write_dots(axis: Axes, entries: Sequence[DesignCandidate], second: str, first: str) -> None:
    """Label designs with their number of markers, alternately left and right."""
    for turn, entry in enumerate(sorted(entries, key=lambda entry: entry.value(first))):
        right = turn % 2 == 0
        axis.annotate(
            f"{entry.option.markers.count} markers",
            (entry.value(second), entry.value(first)),
            (6 if right else -6, 0),
            textcoords="offset points",
            ha="left" if right else "right",
            va="center",
            fontsize="x-small",
        )


def _plain_logarithm(axis: Axes) -> None:
    """Set a logarithmic scale with plain numbers."""
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter("{x:g}")
    axis.yaxis.set_minor_formatter("{x:g}")


def _label(objective: str) -> str:
    words = "95th-percentile error over units" if objective == "error" else objective
    return f"{words}, {UNITS[objective]}".removesuffix(", ")


def draw_design(entry: DesignCandidate, camera: CameraSpec) -> Figure:
    """Draw a design in section with its camera, to scale, and the rest image."""
    skin, eye = entry.trial.finest.skin.build(), build_camera(camera)
    layout = place_markers(skin, entry.option.markers)
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    section, image = figure.subplots(1, 2, width_ratios=(1, 1.25))
    _draw_section(section, skin, layout, camera.distance)
    printed = np.vstack([layout.positions, place_orientation_mark(skin, layout)])
    edges = marker_outlines(skin, printed, layout.diameter)
    image.imshow(render(eye, edges), cmap="gray", vmin=0, vmax=255)
    image.set(title=f"rest image, {eye.width_px} x {eye.height_px} px", xticks=[], yticks=[])
    return figure


def _draw_section(axis: Axes, skin: Skin, layout: MarkerLayout, distance: float) -> None:
    across = np.linspace(-1.0, 1.0, 201)
    disc = np.column_stack([across, np.zeros_like(across)])
    inner, outer = (skin.point(disc, layer)[:, [0, 2]] for layer in (0.0, 1.0))
    axis.add_patch(Polygon(np.concatenate([outer, inner[::-1]]), closed=True, facecolor=_SILICONE, edgecolor="black"))
    cut = layout.positions[np.abs(layout.positions[:, 1]) < layout.diameter / 4]
    axis.plot(cut[:, 0], cut[:, 2], "o", ms=3.0, color="black")
    eye = np.array([0.0, -distance])
    for end in cut[[cut[:, 0].argmin(), cut[:, 0].argmax()]][:, [0, 2]]:
        axis.plot(*np.array([eye, end]).T, color=_GREY, lw=0.8, zorder=0)
    axis.plot(*eye, "s", ms=9, color=_CAMERA)
    axis.text(0.0, -distance + 4.0, "camera", ha="center", fontsize="small")
    axis.axhline(0.0, color=_GREY, lw=0.6, zorder=0)
    axis.set(title=skin.name, xlabel="mm", ylabel="mm, base plane at 0")
    axis.set_aspect("equal", adjustable="datalim")
