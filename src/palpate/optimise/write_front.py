"""Report of a search: one folder with front, progress, and the winner's study."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from palpate.core import provenance, wrap_write_errors
from palpate.core.report import Column, Report, page_markdown, write_csv
from palpate.optimise.design_study import camera_of, winner_study
from palpate.optimise.draw_front import draw_design, draw_front, draw_search
from palpate.optimise.front import WORDS, DesignCandidate, Front, find_best
from palpate.optimise.sobol import SobolIndices, compute_sobol_indices
from palpate.optimise.space import SkinSpace
from palpate.optimise.validation import validation_page
from palpate.study import grid_column

FRONT = "front.json"
"""File of the front in the folder of a search."""
FRONT_COLUMNS = (
    Column("skin", meaning="number of the skin in the search"),
    grid_column("height_mm"),
    grid_column("base_radius_mm"),
    grid_column("thickness_mm"),
    Column("aspect", meaning="height over width of an ellipsoid", deciding=False),
    Column("taper", meaning="thickness at the rim over that at the apex", deciding=False),
    Column("material", deciding=False),
    Column("camera", deciding=False),
    Column("distance_mm", "camera distance", meaning="distance of the camera below the base"),
    grid_column("markers"),
    Column("marker_diameter_mm", deciding=False),
    Column("ring_diameters_mm", meaning="diameters of the rings of markers", deciding=False),
    Column("p95_deg", "95th percentile", form=".4f", meaning="95th percentile over built units of the maximum error"),
    Column("rmse_deg", "angle RMSE", form=".4f", meaning="RMSE of the contact angle, built units", deciding=False),
    Column(
        "coarse_p95_deg",
        "95th percentile, coarse presses",
        form=".4f",
        meaning="95th percentile by the twin of coarse presses",
        deciding=False,
    ),
    Column("force_n", "maximum force", form=".4g", meaning="maximum contact force of any press"),
    Column("size_mm", "outer diameter", deciding=False),
    Column("max_depth_mm", "maximum depth", deciding=False),
    Column("price", deciding=False),
    Column("full_fidelity", meaning="whether it was pressed on the fine mesh", deciding=False),
    Column("feasible", meaning="whether all constraints hold", deciding=False),
)
"""Columns of a design in the tables of a search."""


def write_front(folder: Path, front: Front, command: str) -> None:
    """Write ``report.md``, tables, ``front.json``, figures, and ``winner.yaml``, a study.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    with wrap_write_errors(folder, "Choose another folder."):
        folder.mkdir(parents=True, exist_ok=True)
        names = [column.name for column in FRONT_COLUMNS]
        write_csv(folder / "front.csv", map(describe_entry, (*front.pareto, *front.coarse_pareto)), names)
        write_csv(folder / "tried.csv", map(describe_entry, _best_of_each(front)), names)
        influences = compute_sobol_indices(
            front.trials, SkinSpace.of(front.spec), front.spec.markers, front.spec.seed
        )
        (folder / FRONT).write_text(json.dumps(describe_front(front), indent=2) + "\n", "utf-8")
        (folder / "report.md").write_text(report(front, influences, command), "utf-8")
        draw_search(front).savefig(folder / "search.svg")
        draw_front(front).savefig(folder / "front.svg")
        if front.winner is not None:
            (folder / "winner.yaml").write_text(winner_study(front, front.winner), "utf-8")
            draw_design(front.winner, camera_of(front.spec, front.winner)).savefig(folder / "winner.svg")


def describe_entry(entry: DesignCandidate) -> dict[str, Any]:
    """Return one design by the columns of the tables."""
    proposal, option = entry.trial.finest, entry.option
    coarse = next((each for each in entry.trial.coarse.options if each.markers.count == option.markers.count), option)
    skin = proposal.skin
    return dict(
        zip(
            [column.name for column in FRONT_COLUMNS],
            (
                entry.trial.number,
                skin.height,
                skin.base_radius,
                skin.thickness,
                skin.model_dump().get("aspect", 1.0),
                skin.model_dump().get("taper", 1.0),
                proposal.material,
                option.camera,
                option.distance,
                option.markers.count,
                option.markers.diameter,
                " ".join(f"{ring:g}" for ring in option.markers.ring_diameters or ()),
                round(option.accuracy.p95_deg, 4),
                round(option.accuracy.rmse_deg, 4),
                round(coarse.accuracy.p95_deg, 4),
                round(proposal.force_n, 4),
                round(proposal.size_mm, 2),
                round(proposal.max_depth_mm, 3),
                option.price,
                entry.trial.fine is not None,
                entry.trial.feasible,
            ),
            strict=True,
        )
    )


def describe_front(front: Front) -> dict[str, Any]:
    """Return the front as JSON data, with its settings and versions."""
    return {
        "requirements": front.spec.model_dump(mode="json"),
        "made_with": provenance(),
        "shortfall": front.shortfall,
        "winner": describe_entry(front.winner) if front.winner else None,
        "baseline": asdict(front.baseline) if front.baseline else None,
        "ends": {title: describe_entry(entry) for title, entry in front.extremes},
        "validation": front.validation.as_dict() if front.validation else None,
        "random_skins": {name: describe_entry(best) if best else None for name, _, _, best in _least(front)},
        "front": [describe_entry(entry) for entry in front.pareto],
        "coarse_front": [describe_entry(entry) for entry in front.coarse_pareto],
        "skins": len(front.trials),
        "meeting_the_limits": sum(one.feasible for one in front.trials),
    }


def report(front: Front, influences: SobolIndices, command: str) -> str:
    """Return the report as a Markdown page."""
    spec, winner = front.spec, front.winner
    shares = [(one.name, f"{one.first_order:.2f}", f"{one.total:.2f}") for one in influences.variables]
    parts: list[str | Report] = [
        f"# {spec.name}: designs by search",
        f"```\n{command}\n```",
        f"**{front.shortfall}**" if front.shortfall else "**The requirements are met.**",
        *([] if winner is None else [_winner_line(winner), "![winner](winner.svg)"]),
        "Errors are those of rx and ry of built units, predicted from the twin of each design over the tolerances "
        f"and all frictions, after {spec.calibration_presses} calibration presses: `p95_deg` is the 95th percentile "
        "over units. They are no measurement.",
        *_dropped_lines(front),
        *_end_lines(front),
        *validation_page(front.validation),
        "## The front",
        Report("", FRONT_COLUMNS, [describe_entry(entry) for entry in front.pareto]),
        *_coarse_lines(front),
        "![front](front.svg)",
        "![search](search.svg)",
        *_control_lines(front),
        "## Importance of the variables",
        f"{influences.summary} Over the whole of the searched space, by Sobol's indices of a surface through "
        "the skins that reach the depth, which explains "
        f"{100 * max(influences.explained, 0.0):.0f} % of the variance of skins left out.",
        Report.of("", ("variable", "first-order Sobol index", "total Sobol index"), shares),
        f"{len(front.trials)} skins were tried, {sum(one.feasible for one in front.trials)} meet the limits; seed "
        f"{spec.seed}. Every one is in `tried.csv`.",
    ]
    return page_markdown(parts)


def _winner_line(winner: DesignCandidate) -> str:
    proposal, option = winner.trial.finest, winner.option
    skin = proposal.skin
    return (
        f"The winner is skin {winner.trial.number}: {skin.build().shape}, {skin.height:g} mm high over a radius of "
        f"{skin.base_radius:g} mm, {skin.thickness:g} mm thick, {option.markers.count} markers of "
        f"{option.markers.diameter:g} mm, camera {option.camera} {option.distance:g} mm below the base. The error's "
        f"95th percentile is {option.accuracy.p95_deg:.3f}° (RMSE {option.accuracy.rmse_deg:.3f}°); at most "
        f"{proposal.force_n:.2f} N. `winner.yaml` is its study."
    )


def _dropped_lines(front: Front) -> Iterator[str]:
    """Yield the finalists that broke a limit at full fidelity."""
    for one in front.trials:
        if one.fine is not None and not one.feasible:
            broken = " and ".join(WORDS[name] for name, by in one.violations.items() if by > 0)
            yield f"Skin {one.number} met the limits by coarse presses alone: by fine ones {broken}."


def _coarse_lines(front: Front) -> list[str | Report]:
    """Return the non-dominated designs without fine presses; empty if none exists."""
    if not front.coarse_pareto:
        return []
    found = [describe_entry(entry) for entry in front.coarse_pareto]
    return [
        f"Designs that only coarse presses place on the front: {len(found)}. Raise `finalists` to confirm them:",
        Report("", FRONT_COLUMNS, found),
    ]


def _end_lines(front: Front) -> list[str]:
    """Return lines on the extremes of a front; empty for a single objective."""
    if not front.extremes:
        return []
    bar = f"{front.error_threshold_deg:.3f}°, " + (
        "the predicted error of the baseline" if front.baseline else "the required error"
    )
    lines = []
    for title, entry in front.extremes:
        proposal, option = entry.trial.finest, entry.option
        lines.append(
            f"* {title}: skin {entry.trial.number}, {proposal.skin.build().name}, {option.markers.count} markers of "
            f"{option.markers.diameter:g} mm, camera {option.camera} at {option.distance:g} mm, "
            f"{proposal.force_n:.2f} N, {proposal.size_mm:.1f} mm wide, {option.accuracy.p95_deg:.3f}°"
        )
    return [f"Of the designs whose error is no greater than {bar}:", "\n".join(lines)]


def _least(front: Front) -> Iterator[tuple[str, int, str, DesignCandidate | None]]:
    """Number of evaluations and best feasible design by coarse presses, of search, random search and grid."""
    control = front.search_baselines
    parts = (
        ("search", front.trials, len(front.trials), "skins"),
        ("chance", control.random, len(control.random), "skins"),
        ("grid", control.grid, sum(len(one.coarse.options) for one in control.grid), "designs"),
    )
    return ((name, count, noun, find_best(skins, front.spec.markers)) for name, skins, count, noun in parts if skins)


def _control_lines(front: Front) -> Iterator[str]:
    """Yield the comparison of the search with random search and grid; nothing without a baseline."""
    found = list(_least(front))
    if len(found) < 2:
        return
    yield "Minimum 95th-percentile error of feasible designs, all by the same coarse presses:"
    lines = []
    for name, count, noun, best in found:
        skin = best.trial.coarse.skin.build().name if best else ""
        figures = f"{skin}, {best.option.markers.count} markers: {best.value('error'):.4f}°" if best else "none"
        lines.append(f"* {name}, {count} {noun}: {figures}")
    yield "\n".join(lines)


def _best_of_each(front: Front) -> Sequence[DesignCandidate]:
    found = ((one, one.finest.best(front.spec.markers)) for one in front.trials)
    return [DesignCandidate(one, option) for one, option in found if option is not None]
