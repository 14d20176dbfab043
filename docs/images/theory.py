"""Draw the figures of the theory chapters from the package's own functions.

    python docs/images/theory.py

writes theory_contact.svg, theory_truss.svg and theory_skins.svg beside this file.
"""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from palpate.design import ConeSpec, SplineSpec
from palpate.design.ellipsoid import Ellipsoid
from palpate.mechanics import ContactLaw

HERE = Path(__file__).parent
BLUE, ORANGE, GREEN = "#1f77b4", "#d95f02", "#2a9d5c"


def draw_contact() -> Figure:
    """Pressure over penetration, and the traction of the friction spring over its length."""
    law = ContactLaw(stiffness=1.0, width=1.0, tangential_stiffness=1.0, friction=0.5)
    reach = np.linspace(-1.0, 3.0, 201)
    figure = Figure(figsize=(6.4, 2.4), layout="constrained")
    normal, sliding = figure.subplots(1, 2)
    normal.plot(reach, law.pressure(reach), color=BLUE)
    normal.axvspan(0.0, law.width, color=BLUE, alpha=0.1, lw=0)
    normal.set(xlabel="penetration δ / w", ylabel="pressure p / (ε w)", title="normal")
    spring = np.linspace(0.0, 3.0, 201)
    for at in (2.0, 3.0):
        limit = float(law.friction_limit(np.array([at]))[0])
        sliding.plot(spring, np.minimum(law.tangential_stiffness * spring, limit), color=ORANGE)
        sliding.annotate(f"µ p at δ = {at:g} w", (3.0, limit), ha="right", va="bottom")
    sliding.set(xlabel="spring |s| / w", ylabel="traction / (ε w)", title="tangential", ylim=(0, 1.6))
    return figure


def draw_truss() -> Figure:
    """Force over travel of the von Mises truss of unit height, ``f = z (1 - z²)`` with z = 1 - travel."""
    figure = Figure(figsize=(4.6, 2.6), layout="constrained")
    axis = figure.subplots()
    turn, most = 1.0 - 1.0 / np.sqrt(3.0), 2.0 / (3.0 * np.sqrt(3.0))
    for low, high, style, name in (
        (0.0, turn, "-", "stable"),
        (turn, 2.0 - turn, "--", "unstable: one negative pivot"),
        (2.0 - turn, 2.25, "-", None),
    ):
        z = 1.0 - np.linspace(low, high, 200)
        axis.plot(1.0 - z, z * (1.0 - z**2), style, color=BLUE, label=name)
    far = 1.0 + 2.0 / np.sqrt(3.0)
    axis.annotate("", (far, most), (turn, most), arrowprops={"arrowstyle": "->", "color": ORANGE})
    axis.text(1.25, most, "snap-through", color=ORANGE, ha="center", va="bottom")
    axis.plot([turn, 2.0 - turn], [most, -most], "o", color=ORANGE, ms=4)
    axis.set(xlabel="travel of the apex / h", ylabel="force · L³ / (k h³)", ylim=(-0.45, 0.6))
    figure.legend(loc="outside upper center", frameon=False, fontsize=8, ncols=2)
    return figure


def draw_skins() -> Figure:
    """Meridians of ellipsoids of one height, base and thickness, and of skins of the other kinds."""
    ellipsoids = [(f"aspect {aspect:g}", Ellipsoid(15.0, 20.0, 1.5, aspect)) for aspect in (0.7, 1.0, 1.3)]
    others = [
        ("cone, edge 6", ConeSpec(height=22, base_radius=18, thickness=1.5, edge_radius=6).build()),
        (
            "cone, flat 6, edge 5",
            ConeSpec(height=15, base_radius=18, thickness=1.5, flat_radius=6, edge_radius=5).build(),
        ),
        ("spline, taper 2", SplineSpec(height=18, thickness=1.5, points=((0.5, 0.9), (0.9, 0.4)), taper=2).build()),
    ]
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    disc = np.column_stack([np.linspace(-1.0, 1.0, 401), np.zeros(401)])
    for axis, skins in zip(figure.subplots(2), (ellipsoids, others), strict=True):
        for (name, skin), colour in zip(skins, (GREEN, BLUE, ORANGE), strict=True):
            for layer in (0.0, 1.0):
                points = skin.point(disc, layer)
                label = name if layer == 0.0 else None
                axis.plot(points[:, 0], points[:, 2], color=colour, lw=1.2 if layer else 0.8, label=label)
        axis.axhline(0.0, color="0.6", lw=0.8)
        axis.set(aspect="equal", ylabel="mm")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)
    axis.set(xlabel="mm")
    return figure


def main() -> None:
    """Write all figures, the same to the byte on each run."""
    matplotlib.rcParams |= {"svg.hashsalt": "palpate", "svg.fonttype": "none", "font.size": 9}
    for name, draw in (("contact", draw_contact), ("truss", draw_truss), ("skins", draw_skins)):
        draw().savefig(HERE / f"theory_{name}.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
