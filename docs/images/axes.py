"""Draw the axes of sensor, camera and flange, with their signs, once: axes.svg beside this file.

Signs come from the package: the wall from `wall_normal`, the image from a camera's `project`.
"""

from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np

from palpate.camera import build_camera
from palpate.design import DomeSpec, build_skin, wall_normal

TILT_DEG = 10.0
BLUE, ORANGE, GREY = "#1f5fa8", "#c2571a", "#666666"


def side(axes: plt.Axes) -> None:
    """The y-z plane of the sensor, looked at from +x: wall at rx > 0, camera below, flange below it."""
    skin, normal = build_skin(DomeSpec()), wall_normal(np.radians(TILT_DEG), 0.0)
    angle = np.linspace(0.0, 1.0, 80)
    inner = skin.inner_point(angle * skin.base_radius * 0.999, np.full(80, np.pi / 2))
    for sign in (-1, 1):
        axes.plot(sign * inner[:, 1], inner[:, 2], color=BLUE, lw=2)
    touch = skin.support_point(normal)
    along = np.array([normal[2], -normal[1]])
    ends = touch[1:] + np.outer([-16, 26], along)
    axes.plot(*ends.T, color=ORANGE, lw=2)
    axes.annotate("", touch[1:] + 9 * normal[1:], touch[1:], arrowprops={"arrowstyle": "->", "color": ORANGE})
    axes.text(*(touch[1:] + 9.5 * normal[1:]), "wall's normal", color=ORANGE, ha="right", va="bottom")
    axes.text(
        22, 32, "rx > 0: the wall rises towards +y,\ntouches first on the side of −y", color=ORANGE, ha="center"
    )
    arrow(axes, (0, 0), (14, 0), "y", BLUE)
    arrow(axes, (0, 0), (0, 14), "z", BLUE)
    axes.text(-2, -3.5, "x towards you; depth > 0: the wall\nmoves along −z", color=BLUE, ha="right", va="center")
    axes.plot(0, -18, marker="s", ms=12, color=GREY)
    arrow(axes, (0, -18), (12, -18), "rows", GREY)
    axes.text(-3, -18, "camera, looks along +z", color=GREY, ha="right", va="center")
    axes.plot([-12, 12], [-28, -28], color="k", lw=3)
    arrow(axes, (0, -28), (0, -22), "z of the flange", "k")
    axes.set(xlim=(-38, 38), ylim=(-31, 38), aspect="equal")
    axes.set_title("sensor, from its +x")
    axes.axis("off")


def image(axes: plt.Axes) -> None:
    """The image of the nominal camera: columns along x, rows along y."""
    camera = build_camera()
    width, height = camera.width_px, camera.height_px
    middle, x, y = camera.project(np.array([[0, 0, 0], [14, 0, 0], [0, 14, 0]], float))
    axes.add_patch(plt.Rectangle((0, 0), width, height, fill=False, color=GREY))
    for end, name in ((x, "x, columns"), (y, "y, rows")):
        axes.annotate("", end, middle, arrowprops={"arrowstyle": "->", "color": BLUE})
        axes.text(*end, f" {name}", color=BLUE, va="center")
    axes.text(middle[0], middle[1] - 95, "rx > 0: most motion here (−y)", color=ORANGE, ha="center")
    axes.text(middle[0] + 165, middle[1] + 70, "ry > 0:\nmost motion\nhere (+x)", color=ORANGE, ha="right")
    axes.set(xlim=(-5, width + 5), ylim=(height + 5, -5), aspect="equal")
    axes.set_title("image, nominal camera")
    axes.axis("off")


def arrow(axes: plt.Axes, start: tuple[float, float], end: tuple[float, float], name: str, color: str) -> None:
    """An arrow with its name at the end."""
    axes.annotate("", end, start, arrowprops={"arrowstyle": "->", "color": color})
    axes.text(*end, f" {name}", color=color)


figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.6))
side(left)
image(right)
figure.tight_layout()
figure.savefig(Path(__file__).with_suffix(".svg"), metadata={"Date": None})
