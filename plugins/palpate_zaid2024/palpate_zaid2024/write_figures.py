"""Page of the paper's Table 3, Table 2 and Figs. 8 to 12 in this version, with the printed values.

Figures 9 to 12 are not reprinted. Each picture is followed by the statements of the paper about it, as claims, with
the figures that decide them.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from palpate.core import PAPER, PalpateError, atomic_write, atomic_write_into
from palpate.core.report import Report, page_markdown
from palpate.core.run import Progress
from palpate.design import DomeSpec, build_skin
from palpate.fea import Press, WallSpec, nodal_von_mises, plot_convergence, solve_press
from palpate.material import Mode, get_material, trace_curve
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import PAPER_TABLE_3
from palpate.study import Row, check_plot_request, draw_plot, plot_file_name, write_picture
from palpate_zaid2024.assess_claims import name_sources
from palpate_zaid2024.assess_material import MEASURED_MPA, TABLE_2, read_meshes
from palpate_zaid2024.claim import ClaimAnswer
from palpate_zaid2024.evidence import HEIGHTS, Evidence
from palpate_zaid2024.write_claims import claim_report, plain_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BEST = (20.0, 2.0, 169)
"""Height, thickness (mm) and markers of the sensor that the paper built."""
_DEPTH_MM, _TILT_DEG = 8.0, 12.0
"""Press of Fig. 10: the depth is printed, the tilt is the largest of the study."""
_GRID_FIGURES = (("11", "travel", "travel_mm"), ("12", "heat", "rmse_deg"), ("12", "heat", "max_error_deg"))
"""Number in the paper, kind of picture and metric of figures of a grid."""
_FRAME_MM = 29.0
"""Half width and height of a panel of Fig. 10."""
_RANGE = (0.5, 5.0)
"""Stretches of the paper's tests."""
_MATERIAL = "zaid_2024_ecoflex_00_30"
_NO_PREDICTION = "Degrees, mm for the depth. For a prediction, give the folder of `palpate calibration predict` too."
_MPA = 1e-6
"""MPa in 1 Pa."""


def write_figures(
    folder: Path,
    answers: Sequence[ClaimAnswer],
    grids: Sequence[Evidence],
    meshes: Sequence[Path],
    progress: Progress,
    cells: int | None = None,
) -> Path:
    """Write ``figures.md`` and its pictures; the six domes of Fig. 10 are pressed for it.

    Parameters
    ----------
    folder
        Made if it does not exist.
    answers, grids, meshes
        Assessed claims, and the grids and mesh studies behind them.
    progress
        Receives the presses.
    cells
        Cells from pole to rim of the pressed domes; `None` for those of their size.

    Raises
    ------
    PalpateError
        If the folder cannot be written.
    """
    drawn = [(f"fig_09_{plain_name(path.stem)}", plot_convergence(read_meshes(path))) for path in meshes]
    for evidence, name in zip(grids, name_sources(grids), strict=True):
        for number, kind, metric in _GRID_FIGURES:
            with suppress(PalpateError):  # nothing to draw: the page says so
                check_plot_request(evidence.grid, kind, metric)
                picture = f"fig_{number}_{plot_file_name(kind, metric)}_{plain_name(name)}"
                drawn.append((picture, draw_plot(evidence.grid, kind, metric)))
    presses = _press_domes(cells, progress)
    drawn.append(("fig_08_material", _draw_material()))
    for name, thickness in (("fig_10_stress", 2.0), ("fig_10_thin", 1.0)):
        drawn.append((name, _draw_presses([one for one in presses if one.mesh.skin.thickness == thickness])))
    pictures: dict[str, Figure] = {}
    for name, figure in drawn:
        again = sum(known.startswith(name) for known in pictures)
        pictures[f"{name}_{again + 1}" if name in pictures else name] = figure
    with atomic_write_into(folder, "Choose another with --figures.") as drafts:
        for name, figure in pictures.items():
            write_picture(drafts / name, figure)
    page = folder / "figures.md"
    with atomic_write(page) as draft:
        draft.write_text(page_markdown(_describe(answers, grids, presses, sorted(pictures))), encoding="utf-8")
    return page


def _describe(
    answers: Sequence[ClaimAnswer], grids: Sequence[Evidence], presses: Sequence[Press], pictures: Sequence[str]
) -> list[str | Report]:
    def shown(number: str) -> str:
        lines = [f"![{name}]({name}.svg)" for name in pictures if name.startswith(f"fig_{number}")]
        return "\n\n".join(lines) or "The given results have no such figures."

    def claims(*names: str) -> Report:
        return claim_report([answer for answer in answers if answer.claim.name in names])

    return [
        "# The paper's tables and figures",
        f"Tables 2 and 3 and Figs. 8 to 12 of {PAPER}, with the same quantities of this version.",
        "## Table 3: the real sensor",
        "The paper's errors are those of a sensor that was built and pressed by a robot. **No sensor of this design "
        "was built for palpate.** The last row and columns are the predicted RMSE of the total tilt of built units, "
        "from twins and manufacturing tolerances. They do not confirm the paper's experiment.",
        _table_3(grids),
        "Degrees, mm for the depth." if _read_best(grids) else _NO_PREDICTION,
        "## Table 2: coefficients of the Yeoh law",
        _table_2(),
        "## Fig. 8: material",
        "The law of Table 2, and the two measured stresses that the text states.",
        shown("08"),
        claims("C1"),
        "## Fig. 9: mesh",
        shown("09"),
        claims("C2"),
        "## Fig. 10: stress and deformation",
        f"Domes under a wall tilted by {_TILT_DEG:g}°, no slip, {_DEPTH_MM:g} mm or the depth that was reached.",
        shown("10"),
        _table_10(presses),
        claims("C3", "C4", "C5"),
        "## Fig. 11: marker travel",
        shown("11"),
        claims("C6", "C7", "C8"),
        "## Fig. 12: accuracy",
        shown("12"),
        claims("C9", "C10", "C11", "C12", "C14"),
    ]


def _read_best(grids: Sequence[Evidence]) -> Row:
    """Return the predicted accuracy of built units of the paper's sensor; empty if none was given."""
    return next((one.built[_BEST] for one in grids if _BEST in one.built), {})


def _table_3(grids: Sequence[Evidence]) -> Report:
    built = _read_best(grids)
    ours = [built.get(f"{when}_rmse_deg", "") for when in ("built", "calibrated")]
    rows = [[name, one.rmse, one.mae, one.max, one.sd, "", ""] for name, one in PAPER_TABLE_3.items()]
    rows.append(["total tilt", *[""] * 4, *ours])
    headings = (
        "component", "RMSE, paper", "MAE, paper", "maximum, paper", "SD, paper", "predicted RMSE as built (°)",
        "after calibration presses (°)",
    )  # fmt: skip
    return Report.of("", headings, rows)


def _table_2() -> Report:
    paper, ours = get_material(TABLE_2).law, get_material(_MATERIAL).law
    rows = [[name, *(f"{getattr(law, name) / _MPA:g}" for law in (paper, ours))] for name in ("C10", "C20", "C30")]
    return Report.of("", ("coefficient", "paper (Pa)", f"`{_MATERIAL}` (Pa)"), rows)


def _table_10(presses: Sequence[Press]) -> Report:
    rows = [
        [press.mesh.skin.name, f"{press.depth[-1]:.1f}", str(press.branch[-1]), f"{press.peak_stress[-1]:.4f}"]
        for press in presses
    ]
    return Report.of("", ("dome", "depth (mm)", "state", "maximum von Mises stress (MPa)"), rows)


def _press_domes(cells: int | None, progress: Progress) -> list[Press]:
    domes = [(height, thickness) for thickness in (2.0, 1.0) for height in HEIGHTS]
    wall, presses = WallSpec(tilt_deg=_TILT_DEG, depth=_DEPTH_MM), []
    progress.plan(len(domes))
    for height, thickness in domes:
        what = f"Fig. 10: H{height:g} T{thickness:g}"
        progress.begin(what)
        mesh = mesh_skin(build_skin(DomeSpec(height=height, thickness=thickness)), MeshSpec(cells=cells))
        presses.append(solve_press(mesh, get_material(TABLE_2), wall))
        progress.finish(what)
    return presses


def _draw_material() -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2, 3.6), layout="constrained")
    axis = figure.subplots()
    stretch = np.linspace(*_RANGE, 200)
    axis.plot(stretch, trace_curve(get_material(TABLE_2), Mode.UNIAXIAL, stretch).nominal, label="law of Table 2")
    axis.plot(list(MEASURED_MPA), list(MEASURED_MPA.values()), "o", color="C3", label="measured, text of the paper")
    axis.set_xlabel("stretch")
    axis.set_ylabel("nominal stress (MPa)")
    axis.legend(frameon=False)
    axis.spines[["top", "right"]].set_visible(False)
    return figure


def _draw_presses(presses: Sequence[Press]) -> Figure:
    """Draw the deformed section in the plane of the tilt, coloured by von Mises stress, one panel a dome."""
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.4 * len(presses), 3.2), layout="constrained")
    axes = figure.subplots(1, len(presses), sharey=True)
    most = max(float(np.max(press.peak_stress[-1])) for press in presses[1:])
    for axis, press in zip(axes, presses, strict=True):
        mesh, stress = press.mesh, nodal_von_mises(press)[-1]
        moved, inside = mesh.nodes + press.displacement[-1], np.flatnonzero(np.abs(mesh.nodes[:, 0]) < 1e-9)
        inner, outer = (np.intersect1d(inside, faces) for faces in (mesh.inner_faces, mesh.outer_faces))
        inner, outer = (line[np.argsort(mesh.inner_disc[line, 1])] for line in (inner, outer))
        corners = np.stack([inner[:-1], inner[1:], outer[1:], outer[:-1]], axis=1)
        strip = PolyCollection(list(moved[corners][:, :, 1:]), cmap="viridis", edgecolors="face")
        strip.set_array(stress[corners].mean(axis=1))
        strip.set_clim(0.0, most)
        axis.add_collection(strip)
        axis.set_title(f"{mesh.skin.name}, {press.depth[-1]:.1f} mm", fontsize=10)
        axis.set_xlabel("across (mm)")
        axis.set(xlim=(-_FRAME_MM, _FRAME_MM), ylim=(0.0, _FRAME_MM), aspect="equal")
    axes[0].set_ylabel("height (mm)")
    figure.colorbar(strip, ax=list(axes), label="von Mises stress (MPa)", shrink=0.8, extend="max")
    return figure
