"""A press as a figure and as a table, for notebooks and reports."""

from __future__ import annotations

import ctypes
import html
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError, load_extra
from palpate.fea.nodal_stress import nodal_von_mises

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from palpate.fea.press import Press

_GRAPHICS = "libEGL.so.1"
_GRID = 121
"""Points along each axis by which the surface of the obstacle is drawn."""
_DRAWN = 4
"""Number of outlines of the section that are drawn, from rest to the end."""


def plot_press(press: Press) -> Figure:
    """Draw a press: its section in the tilt plane at several depths, and the force over the depth."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.4, 3.4), layout="constrained")
    section, curve = figure.subplots(1, 2)
    chosen = np.unique(np.linspace(0, len(press.depth) - 1, _DRAWN).astype(int))
    for increment, shade in zip(chosen, np.linspace(0.75, 0.1, len(chosen)), strict=True):
        _draw_section(section, press, int(increment), str(shade))
    _draw_obstacle(section, press)
    section.set_aspect("equal")
    section.set_xlabel("across, in the plane of the tilt (mm)")
    section.set_ylabel("height (mm)")
    force = np.linalg.norm(press.force, axis=1)
    for branch, style in (("flat", "o-"), ("inverted", "s--"), ("neither", "^:")):
        here = press.branch == branch
        if here.any():
            curve.plot(press.depth[here], force[here], style, label=branch, color="C0" if branch == "flat" else "C1")
    curve.set_xlabel("depth (mm)")
    curve.set_ylabel("force on the wall (N)")
    curve.legend(frameon=False)
    for axis in (section, curve):
        axis.spines[["top", "right"]].set_visible(False)
    title = f"{press.mesh.skin.name}, {press.obstacle.label}: {press.ended}"
    figure.suptitle(title, fontsize=11)
    return figure


def tabulate_press(press: Press) -> str:
    """Return a press as an HTML table, one row for each increment."""
    heads = ("depth (mm)", "force (N)", "peak stress (MPa)", "contact (mm²)", "branch")
    force = np.linalg.norm(press.force, axis=1)
    figures = zip(press.depth, force, press.peak_stress, press.contact_area, strict=True)
    rows = [
        (f"{depth:.2f}", f"{newton:.4f}", f"{stress:.4f}", f"{area:.1f}", str(branch))
        for (depth, newton, stress, area), branch in zip(figures, press.branch, strict=True)
    ]
    return html_table(f"Press, ended: {press.ended} at {press.ended_depth:.2f} mm", heads, rows)


def html_table(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table with a title, its texts escaped."""
    line = "".join(f"<th>{html.escape(head)}</th>" for head in heads)
    body = "".join(f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><caption>{html.escape(title)}</caption><tr>{line}</tr>{body}</table>"


def render_press_3d(press: Press, increment: int = -1, path: Path | None = None) -> NDArray[np.uint8]:
    """Render the pressed skin in 3-D, coloured by von Mises stress, as (h, w, 3) colours.

    If `path` is given, a PNG file is written as well.

    Raises
    ------
    MissingExtraError
        If pyvista is not installed.
    PalpateError
        If this machine has no OpenGL, or the file cannot be written.
    """
    check_graphics()
    pyvista = load_extra("pyvista", "viz")
    plotter = pyvista.Plotter(off_screen=True, window_size=(800, 600))
    try:
        plotter.add_mesh(
            _surface(pyvista, press, increment), scalars="von Mises (MPa)", cmap="viridis", show_edges=False
        )
        plotter.view_isometric()
        drawn: NDArray[np.uint8] = np.asarray(
            plotter.screenshot(None if path is None else str(path), return_img=True)
        )
    except OSError as error:
        raise PalpateError(
            f"{path} cannot be written: {error.strerror}.", "Choose another file.", code="file-unwritable"
        ) from error
    finally:
        plotter.close()
    return drawn


def check_graphics() -> None:
    """Check for OpenGL's library, without which the 3-D library would end the whole program.

    Raises
    ------
    PalpateError
        If the library is missing.
    """
    try:
        ctypes.CDLL(_GRAPHICS)
    except OSError:
        raise PalpateError(
            f"This machine has no {_GRAPHICS}, which 3-D images require.",
            "On Debian: apt-get install libegl1. Or draw in 2-D by plot(), or in the browser by `palpate view`.",
            code="graphics-missing",
        ) from None


def _surface(pyvista: Any, press: Press, increment: int) -> Any:
    """Return both halves of the deformed surfaces as one mesh of quadrilaterals."""
    mesh = press.mesh
    quads = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
    faces = np.concatenate([mesh.outer_faces, mesh.inner_faces])[:, quads].reshape(-1, 4)
    cells = np.column_stack([np.full(len(faces), 4), faces])
    points = mesh.nodes + press.displacement[increment]
    stress = nodal_von_mises(press)[increment]
    halves = []
    for side in (1.0,) if mesh.spec.whole else (1.0, -1.0):
        half = pyvista.PolyData(points * [side, 1.0, 1.0], cells.ravel())
        half["von Mises (MPa)"] = stress
        halves.append(half)
    return halves[0].merge(halves[1]) if len(halves) > 1 else halves[0]


def _draw_obstacle(axis: Any, press: Press) -> None:
    """Draw the surface of the obstacle at the last depth in the section x = 0."""
    obstacle = press.obstacle.path(press.mesh)(float(press.depth[-1]))
    y, z = np.meshgrid(*(np.linspace(low, high, _GRID) for low, high in (axis.get_xlim(), axis.get_ylim())))
    points = np.column_stack([np.zeros(y.size), y.ravel(), z.ravel()])
    shown = axis.contour(y, z, obstacle.penetration(points).reshape(y.shape), levels=[0.0], colors="C3")
    axis.clabel(shown, fmt=str(getattr(press.obstacle, "kind", "wall")).replace("_", " "), fontsize=8)


def _draw_section(axis: Any, press: Press, increment: int, shade: str) -> None:
    """Draw the inner and outer outline of the deformed section x = 0."""
    mesh = press.mesh
    inside = np.flatnonzero(np.abs(mesh.nodes[:, 0]) < 1e-9)
    moved = mesh.nodes + press.displacement[increment]
    for faces in (mesh.inner_faces, mesh.outer_faces):
        line = np.intersect1d(inside, faces)
        line = line[np.argsort(mesh.inner_disc[line, 1])]
        label = f"{press.depth[increment]:.1f} mm" if faces is mesh.inner_faces else None
        axis.plot(moved[line, 1], moved[line, 2], color=shade, linewidth=1.4, label=label)
    axis.legend(frameon=False, fontsize=8, loc="lower center", ncols=2)
