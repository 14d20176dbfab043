"""Page of the assessed claims, in Markdown or HTML, with pictures of each grid's figures."""

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
"""Kind and metric of the picture that shows the deciding figures of a claim."""
COLUMNS = (
    Column("claim"),
    Column("statement", "the paper", prose=True),
    Column("test", "it holds if", deciding=False, prose=True),
    Column("source", "in", deciding=False, prose=True),
    Column("figures", prose=True),
    Column("verdict", prose=True),
)

OF_DOMES = ("C3", "C4", "C5")
"""Claims about domes; all layouts share their figures, so one panel is enough."""

Pictures = Mapping[tuple[str, str], str]
"""Path of a picture, relative to the page, by claim and source."""


def write_claims(
    path: Path, answers: Sequence[ClaimAnswer], grids: Sequence[Evidence], command: str
) -> tuple[Path, ...]:
    """Write a page of answers, and one picture per claim and grid into a folder of the page's name.

    Parameters
    ----------
    path
        Ends in ``.md`` or ``.html``.
    answers
        Answers to write.
    grids
        Grids from which the answers were computed.
    command
        Command that makes the page.

    Returns
    -------
    tuple[Path, ...]
        The page and its pictures.

    Raises
    ------
    PalpateError
        If the ending is unknown, or a file cannot be written.
    """
    form = {".md": describe_claims, ".html": _describe_in_html}.get(path.suffix.lower())
    if form is None:
        raise PalpateError(
            f"The file ending of '{path.name}' is unknown.",
            "Choose a name that ends in .md or .html.",
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
    """Return the page as Markdown; for parameters see `write_claims`."""
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
    """Return the answers as a table, one row per claim and source."""
    return Report.of("", COLUMNS, _cells(answers))


def _intro(answers: Sequence[ClaimAnswer], grids: Sequence[Evidence]) -> list[str]:
    counts = Counter(answer.finding.verdict for answer in answers)
    tally = ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict)
    designs = ", ".join(
        f"{name}: {len(evidence.rows)} of the paper's 48 designs"
        for evidence, name in zip(grids, name_sources(grids), strict=True)
    )
    return [
        f"Claims of {PAPER}, compared with our grids ({designs or 'none'}). "
        f"Each verdict is computed from the figures by the test in its row: {tally}, over "
        f"{len({answer.claim.name for answer in answers})} claims. Errors are those on held-out presses; the claim "
        "about the real sensor (C13) is omitted. Made by",
    ]


def _cells(answers: Sequence[ClaimAnswer]) -> list[list[str]]:
    """Return the cells of each row; statement and test of a claim appear once."""
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
    """Write the pictures for which a grid has figures; return their paths by claim and source."""
    written: dict[tuple[str, str], Path] = {}
    for evidence, name in zip(grids, name_sources(grids), strict=True):
        for claim, (kind, metric) in PICTURES.items():
            grid = _first_layout(evidence.grid) if claim in OF_DOMES else evidence.grid
            try:
                check_plot_request(grid, kind, metric)
            except PalpateError:  # nothing to draw: the answer says what is missing
                continue
            path = folder / f"{plot_file_name(kind, metric)}_{plain_name(name)}.svg"
            if path not in written.values():
                _write_picture(path, draw_plot(grid, kind, metric))
            written[claim, name] = path
    return written


def _first_layout(grid: SpecificationGrid) -> SpecificationGrid:
    """Return the designs of the first layout."""
    return grid.select([row for row in grid.designs if row["markers"] == grid.designs[0]["markers"]])


def _write_picture(path: Path, figure: Figure) -> None:
    # imported here because a drawing library loads slowly
    from palpate.study import write_picture

    with atomic_write_into(path.parent) as folder:
        write_picture(folder / path.name, figure)


def plain_name(name: str) -> str:
    """Convert a name to a part of a file name."""
    return "_".join("".join(c if c.isalnum() else " " for c in name).split())
