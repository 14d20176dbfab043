"""The report of a search: one folder with the front, how the search went, and the winner's study."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from palpate.core import provenance, writing, written_whole
from palpate.optimise.design_study import winner_study
from palpate.optimise.front import Entry, Front
from palpate.optimise.influence import Influences, find_influences
from palpate.optimise.proof import proof_lines
from palpate.optimise.space import SkinSpace

FRONT = "front.json"
"""File of the front in the folder of a search."""
UNITS = {"error": "deg", "force": "N", "markers": "", "price": "", "size": "mm"}
"""Units of the objectives."""
_COLUMNS = (
    "skin",
    "height_mm",
    "base_radius_mm",
    "thickness_mm",
    "aspect",
    "taper",
    "material",
    "camera",
    "distance_mm",
    "markers",
    "dot_mm",
    "ring_diameters_mm",
    "worst_deg",
    "rmse_deg",
    "coarse_worst_deg",
    "force_n",
    "size_mm",
    "reach_mm",
    "price",
    "full_fidelity",
    "meets",
)


def write_front(folder: Path, front: Front, command: str) -> None:
    """Write ``report.md``, ``front.csv``, ``tried.csv``, ``front.json``, pictures, and ``winner.yaml``, a study.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    with writing(folder, "Choose another folder."):
        folder.mkdir(parents=True, exist_ok=True)
        _write_rows(folder / "front.csv", map(describe_entry, front.best))
        _write_rows(folder / "tried.csv", map(describe_entry, _best_of_each(front)))
        influences = find_influences(front.tried, SkinSpace.of(front.spec), front.spec.markers, front.spec.seed)
        (folder / FRONT).write_text(json.dumps(describe_front(front), indent=2) + "\n", "utf-8")
        (folder / "report.md").write_text(report(front, influences, command), "utf-8")
        draw_search(front).savefig(folder / "search.svg")
        draw_front(front).savefig(folder / "front.svg")
        if front.winner is not None:
            (folder / "winner.yaml").write_text(winner_study(front, front.winner), "utf-8")


def describe_entry(entry: Entry) -> dict[str, Any]:
    """One design by the columns of the tables."""
    proposal, option = entry.tried.known, entry.option
    coarse = next(
        (each for each in entry.tried.proposal.options if each.markers.count == option.markers.count), option
    )
    skin = proposal.skin
    return dict(
        zip(
            _COLUMNS,
            (
                entry.tried.number,
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
                round(option.figure.worst_deg, 4),
                round(option.figure.rmse_deg, 4),
                round(coarse.figure.worst_deg, 4),
                round(proposal.force_n, 4),
                round(proposal.size_mm, 2),
                round(proposal.reach_mm, 3),
                option.price,
                entry.tried.full is not None,
                entry.tried.meets,
            ),
            strict=True,
        )
    )


def describe_front(front: Front) -> dict[str, Any]:
    """The front as JSON data, with how it was made."""
    return {
        "requirements": front.spec.model_dump(mode="json"),
        "made_with": provenance(),
        "shortfall": front.shortfall,
        "winner": describe_entry(front.winner) if front.winner else None,
        "rival": asdict(front.rival) if front.rival else None,
        "ends": {title: describe_entry(entry) for title, entry in front.ends},
        "proof": front.proof.as_dict() if front.proof else None,
        "front": [describe_entry(entry) for entry in front.best],
        "skins": len(front.tried),
        "meeting_the_limits": sum(one.meets for one in front.tried),
    }


def report(front: Front, influences: Influences, command: str) -> str:
    """The page that a person reads."""
    spec, winner = front.spec, front.winner
    lines = [f"# {spec.name}: designs by search", "", "```", command, "```", ""]
    lines += [f"**{front.shortfall}**" if front.shortfall else "**The requirements are met.**", ""]
    if winner is not None:
        lines += [*_winner_lines(winner), ""]
    lines += [
        "Errors are those of rx and ry of built units, foreseen from the twin of each design over the tolerances and "
        f"all frictions, after {spec.known} known presses: `worst_deg` is what 19 of 20 units stay below. They are "
        "no measurement.",
        "",
        *_end_lines(front),
        *proof_lines(front.proof),
        "## The front",
        "",
        "| " + " | ".join(_COLUMNS) + " |",
        "|" + "---|" * len(_COLUMNS),
        *("| " + " | ".join(str(cell) for cell in describe_entry(entry).values()) + " |" for entry in front.best),
        "",
        "![front](front.svg)",
        "",
        "![search](search.svg)",
        "",
        "## What matters",
        "",
        f"{influences.sentence} Over the whole of the searched space, by Sobol's indices of a surface through "
        f"the skins tried, which explains {100 * max(influences.explained, 0.0):.0f} % of the variance of skins "
        "left out.",
        "",
        "| variable | alone | with others |",
        "|---|---|---|",
        *(f"| {one.name} | {one.alone:.2f} | {one.together:.2f} |" for one in influences.variables),
        "",
        f"{len(front.tried)} skins were tried, {sum(one.meets for one in front.tried)} meet the limits; seed "
        f"{spec.seed}. Every one is in `tried.csv`.",
        "",
    ]
    return "\n".join(lines)


def draw_search(front: Front) -> Figure:
    """Least error found so far over the skins tried."""
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axis = figure.add_subplot()
    best = [(one.number, one.proposal.best(front.spec.markers), one.meets) for one in front.tried]
    for meets, colour, words in ((True, "#1864ab", "meets the limits"), (False, "#adb5bd", "does not")):
        points = [(number, option.figure.worst_deg) for number, option, fine in best if option and fine is meets]
        if points:
            axis.plot(*np.array(points).T, "o", ms=4, color=colour, label=words)
    so_far = [(number, option.figure.worst_deg) for number, option, fine in best if option and fine]
    if so_far:
        numbers, errors = np.array(so_far).T
        axis.step(numbers, np.minimum.accumulate(errors), where="post", color="#1864ab", label="least so far")
    axis.axhline(front.spec.error_deg, color="#c92a2a", lw=0.8, ls="--", label="wanted")
    axis.set(yscale="log", xlabel="skins tried", ylabel="error of 19 of 20 units, deg")
    axis.legend(fontsize="small")
    return figure


def draw_front(front: Front) -> Figure:
    """The front over its first two objectives; over the number of markers where there is one."""
    names = front.spec.objectives if len(front.spec.objectives) > 1 else (*front.spec.objectives, "markers")
    first, second = (name if name != names[0] or k == 0 else "error" for k, name in enumerate(names[:2]))
    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axis = figure.add_subplot()
    every = [(entry.value(second), entry.value(first)) for entry in front.entries]
    if every:
        axis.plot(*np.array(every).T, ".", color="#adb5bd", label="every design that meets the limits")
        axis.plot(
            *np.array([(entry.value(second), entry.value(first)) for entry in front.best]).T,
            "o",
            color="#1864ab",
            label="front",
        )
        axis.legend(fontsize="small")
    axis.set(xlabel=_label(second), ylabel=_label(first), yscale="log")
    return figure


def _label(objective: str) -> str:
    words = "error of 19 of 20 units" if objective == "error" else objective
    return f"{words}, {UNITS[objective]}".removesuffix(", ")


def _winner_lines(winner: Entry) -> list[str]:
    proposal, option = winner.tried.known, winner.option
    skin = proposal.skin
    return [
        f"The winner is skin {winner.tried.number}: {skin.build().shape}, {skin.height:g} mm high over a radius of "
        f"{skin.base_radius:g} mm, {skin.thickness:g} mm thick, {option.markers.count} dots of "
        f"{option.markers.diameter:g} mm, camera {option.camera} {option.distance:g} mm below the base. 19 of 20 "
        f"units stay below {option.figure.worst_deg:.3f}° (RMSE {option.figure.rmse_deg:.3f}°); at most "
        f"{proposal.force_n:.2f} N. `winner.yaml` is its study.",
    ]


def _end_lines(front: Front) -> list[str]:
    """The ends of a front of several objectives; nothing where there is one."""
    if not front.ends:
        return []
    bar = f"{front.bar_deg:.3f}°, " + ("as is foreseen of the rival" if front.rival else "as is wanted")
    lines = [f"Of the designs whose error is no greater than {bar}:", ""]
    for title, entry in front.ends:
        proposal, option = entry.tried.known, entry.option
        lines.append(
            f"* {title}: skin {entry.tried.number}, {proposal.skin.build().name}, {option.markers.count} dots of "
            f"{option.markers.diameter:g} mm, camera {option.camera} at {option.distance:g} mm, "
            f"{proposal.force_n:.2f} N, {proposal.size_mm:.1f} mm wide, {option.figure.worst_deg:.3f}°"
        )
    return [*lines, ""]


def _best_of_each(front: Front) -> Sequence[Entry]:
    found = ((one, one.known.best(front.spec.markers)) for one in front.tried)
    return [Entry(one, option) for one, option in found if option is not None]


def _write_rows(path: Path, rows: Iterable[dict[str, Any]]) -> None:
    with written_whole(path) as draft, draft.open("w", newline="") as file:
        table = csv.DictWriter(file, _COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
