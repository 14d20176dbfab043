"""Figure of an inspection: all markers seen from the camera's side, with print errors as arrows."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.sensor.inspect_unit import Inspection
from palpate.vision import PrintDistortion

ENLARGED = 20.0
"""Maximum magnification of the arrows relative to the errors,"""
LONGEST_MM = 4.0
"""and length of the longest arrow, mm, that limits it further."""


def _draw_rings(axis: Axes, law: PrintDistortion) -> None:
    """Draw the rings as printed."""
    for number in range(1, len(law.rings) + 1):
        members = law.rings.members(number)
        ring = law.positions[np.append(members, members[0]), :2]
        label = "rings as printed" if number == 1 else None
        axis.plot(*ring.T, "-", color="#2b8a3e", lw=0.8, label=label)


def draw_inspection(inspection: Inspection) -> Figure:
    """Draw marker positions and print errors of an inspection in the base plane."""
    figure = Figure(figsize=(6.4, 6.0), layout="constrained")
    axis = figure.add_subplot()
    x, y = inspection.unit.design.layout.positions[:, :2].T
    azimuth = np.arctan2(y, x)
    azimuth[np.hypot(x, y) < 1e-9] = 0.0
    out, around = inspection.error.T
    u = out * np.cos(azimuth) - around * np.sin(azimuth)
    v = out * np.sin(azimuth) + around * np.cos(azimuth)
    longest = float(np.nanmax(inspection.distance, initial=1e-9))
    enlarged = min(ENLARGED, float(f"{max(LONGEST_MM / longest, 1.0):.1g}"))
    missing, outside = inspection.missing, inspection.outside
    kept = np.setdiff1d(np.arange(len(x)), np.concatenate([missing, outside]))
    for chosen, marker, colour, words in (
        (kept, "o", "#00538c", f"within {inspection.tolerance:g} mm"),
        (outside, "s", "#d1622b", "outside"),
        (missing, "x", "#000000", "not found"),
    ):
        if len(chosen):
            axis.plot(x[chosen], y[chosen], marker, color=colour, ms=4, label=f"{words}: {len(chosen)}")
            axis.quiver(
                *(x[chosen], y[chosen], enlarged * u[chosen], enlarged * v[chosen]),
                angles="xy", scale_units="xy", scale=1.0, width=0.003, color=colour,
            )  # fmt: skip
    radius = inspection.unit.design.skin.base_radius
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    axis.plot(radius * np.cos(angle), radius * np.sin(angle), color="#888888", lw=0.8)
    if inspection.distortion is not None:
        _draw_rings(axis, inspection.distortion)
    axis.set(aspect="equal", xlabel="x, mm", ylabel="y, mm", title=f"Print errors, arrows {enlarged:g} : 1")
    axis.legend(loc="upper right", fontsize=8)
    return figure
