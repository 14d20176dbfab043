"""The answers to the paper's claims as a page: Markdown or HTML, with a picture of each grid's figures."""

from __future__ import annotations

import html
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from palpate.core import PAPER, PalpateError, atomic_write, atomic_write_into, wrap_write_errors
from palpate.core.report import Column, Report, page_markdown, report_html
from palpate.study import SpecificationGrid, check_plot_request, draw_plot, plot_file_name
from palpate_zaid2024.assess_claims import name_sources
from palpate_zaid2024.claim import CLAIMS, ClaimAnswer, Verdict
from palpate_zaid2024.evidence import Evidence

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = {
    "C3": ("heat", "peak_stress_straight_mpa"),
    "C4": ("heat", "displacement_mean_straight_mm"),
    "C5": ("heat", "bistable_from_mm"),
    "C6": ("markers", "travel_mm"),
    "C7": ("heat", "travel_mm"),
    "C8": ("travel", "travel_mm"),
    "C9": ("markers", "rmse_deg"),
    "C10": ("heat", "rmse_deg"),
    "C11": ("heat", "rmse_jitter_deg"),
    "C12": ("travel", "rmse_deg"),
    "C14": ("heat", "max_error_deg"),
}
"""Kind and metric of the picture that shows what decides a claim."""
COLUMNS = (
    Column("claim"),
    Column("statement", "the paper", prose=True),
    Column("test", "it holds if", deciding=False, prose=True),
    Column("source", "in", deciding=False, prose=True),
    Column("figures", prose=True),
    Column("verdict", prose=True),
)

OF_DOMES = ("C3", "C4", "C5")
"""Claims about domes, whose figures all layouts share: one panel is enough."""

Pictures = Mapping[tuple[str, str], str]
"""Path of a picture, relative to the page, by claim and source."""


def write_claims(
    path: Path, answers: Sequence[ClaimAnswer], grids: Sequence[Evidence], command: str
) -> tuple[Path, ...]:
    """Write a page of answers, and one picture a claim and grid into a folder of the page's name beside it.

    Parameters
    ----------
    path
        Ends in ``.md`` or ``.html``.
    answers
        What is written.
    grids
        What the answers stand on.
    command
        The command that makes the page.

    Returns
    -------
    tuple[Path, ...]
        The page and its pictures.

    Raises
    ------
    PalpateError
        If the ending is another, or something cannot be written.
    """
    form = {".md": describe_claims, ".html": _describe_in_html}.get(path.suffix.lower())
    if form is None:
        raise PalpateError(
            f"The claims cannot be written as '{path.name}'.",
            "Let the name end in .md or .html.",
            code="file-ending-unknown",
        )
    with wrap_write_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    pictures = _write_pictures(path.parent / path.stem, grids)
    relative = {key: f"{path.stem}/{picture.name}" for key, picture in pictures.items()}
    with atomic_write(path) as draft:
        draft.write_text(form(answers, grids, command, relative), encoding="utf-8")
    return path, *pictures.values()


def describe_claims(
    answers: Sequence[ClaimAnswer], grids: Sequence[Evidence], command: str, pictures: Pictures | None = None
) -> str:
    """The page as Markdown; for parameters see `write_claims`."""
    rows = _cells(answers)
    for answer, words in zip(answers, rows, strict=True):
        picture = (pictures or {}).get((answer.claim.name, answer.source))
        words[-1] = f"**{answer.finding.verdict}**" + words[-1].removeprefix(str(answer.finding.verdict))
        words[4] += f" ([picture]({picture}))" if picture else ""
    table = Report.of("", COLUMNS, rows)
    return page_markdown(
        ["# The paper's claims", *_intro(answers, grids), f"```\n{command}\n```", table, *_provenance(grids)]
    )


def _describe_in_html(
    answers: Sequence[ClaimAnswer], grids: Sequence[Evidence], command: str, pictures: Pictures
) -> str:
    table = report_html(claim_report(answers))
    shown = {path: html.escape(f"{claim}, {source}") for (claim, source), path in pictures.items()}
    images = "".join(f'<p><img src="{html.escape(path)}" width="480" alt="{alt}"></p>' for path, alt in shown.items())
    intro = "".join(f"<p>{html.escape(line)}</p>" for line in _intro(answers, grids))
    origin = "".join(f"<p>{html.escape(line)}</p>" for line in _provenance(grids))
    style = "body{font:15px sans-serif;margin:2em}td,th{border:1px solid #ccc;padding:.4em;vertical-align:top}"
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>The paper\'s claims</title>'
        f"<style>{style}table{{border-collapse:collapse}}</style></head><body><h1>The paper's claims</h1>{intro}"
        f"<pre>{html.escape(command)}</pre>{table}{images}{origin}</body></html>\n"
    )


def claim_report(answers: Sequence[ClaimAnswer]) -> Report:
    """Answers as a table, a row a claim and source."""
    return Report.of("", COLUMNS, _cells(answers))


def _intro(answers: Sequence[ClaimAnswer], grids: Sequence[Evidence]) -> list[str]:
    counts = Counter(answer.finding.verdict for answer in answers)
    tally = ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict)
    designs = ", ".join(
        f"{name}: {len(evidence.rows)} of the paper's 48 designs"
        for evidence, name in zip(grids, name_sources(grids), strict=True)
    )
    return [
        f"Claims of {PAPER}, held against our grids ({designs or 'none'}). "
        f"Every verdict is computed from the figures by the test beside it: {tally}, over "
        f"{len({answer.claim.name for answer in answers})} claims. Errors are those on held-out presses; the claim "
        "of the real sensor (C13) is not among them. Made by",
    ]


def _cells(answers: Sequence[ClaimAnswer]) -> list[list[str]]:
    """Words of each row; a claim is named once."""
    rows, last = [], ""
    for answer in answers:
        claim, finding = CLAIMS[answer.claim.name], answer.finding
        again = claim.name == last
        verdict = f"{finding.verdict}: {finding.why}" if finding.why else str(finding.verdict)
        words = ["", ""] if again else [claim.statement, claim.test]
        rows.append([claim.name, *words, answer.source, finding.figures or "–", verdict])
        last = claim.name
    return rows


def _provenance(grids: Sequence[Evidence]) -> list[str]:
    lines = []
    for evidence, name in zip(grids, name_sources(grids), strict=True):
        facts = [json.loads(str(row["versions"])) for row in evidence.grid.designs if row.get("versions")]
        versions = sorted({" ".join(f"{name}={version}" for name, version in one.items()) for one in facts})
        seeds = sorted({str(row["seed"]) for row in evidence.grid.designs})
        lines.append(f"{name}: seed {', '.join(seeds)}; {' / '.join(versions)}")
    return lines


def _write_pictures(folder: Path, grids: Sequence[Evidence]) -> dict[tuple[str, str], Path]:
    """Pictures of what the grids have figures for, by claim and source."""
    written: dict[tuple[str, str], Path] = {}
    for evidence, name in zip(grids, name_sources(grids), strict=True):
        for claim, (kind, metric) in PICTURES.items():
            grid = _first_layout(evidence.grid) if claim in OF_DOMES else evidence.grid
            try:
                check_plot_request(grid, kind, metric)
            except PalpateError:  # nothing to draw: the answer says what is missing
                continue
            path = folder / f"{plot_file_name(kind, metric)}_{_plain(name)}.svg"
            if path not in written.values():
                _write_picture(path, draw_plot(grid, kind, metric))
            written[claim, name] = path
    return written


def _first_layout(grid: SpecificationGrid) -> SpecificationGrid:
    """The designs of the layout that comes first."""
    return grid.select([row for row in grid.designs if row["markers"] == grid.designs[0]["markers"]])


def _write_picture(path: Path, figure: Figure) -> None:
    # imported here because a drawing library loads slowly
    from palpate.study import write_picture

    with atomic_write_into(path.parent) as folder:
        write_picture(folder / path.name, figure)


def _plain(name: str) -> str:
    """A name as part of a file's name."""
    return "_".join("".join(c if c.isalnum() else " " for c in name).split())
