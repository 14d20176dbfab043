"""Claims about errors: C9 to C12 and C14.

Errors on clean images decide. Errors on jittered images are reported as well, and those of built units if predicted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from palpate_zaid2024.claim import MOSTLY, ClaimFinding
from palpate_zaid2024.evidence import DESIGNS, HEIGHTS, MARKERS, THICKNESSES, Design, Evidence

LITTLE = 0.1
"""Share of the fall from 7 to 91 markers below which the fall from 91 to 169 counts as small."""
BEST: Design = (20.0, 2.0, 169)
"""The paper's best design."""
PRINTED_RMSE_DEG, PRINTED_MAX_DEG = 0.3, 0.8
OF_PRINTED = "which jittered images at full depth reproduce (docs/published/paper_protocol.md)"
AEROSPACE_LIMIT_DEG = 2.0
"""Error limit of claim C14."""

CLEAN, JITTERED = "rmse_deg", "rmse_jitter_deg"
NEIGHBOURS = {
    JITTERED: "with jitter",
    "built_rmse_deg": "as built",
    "calibrated_rmse_deg": "built, after calibration presses",
}
"""Labels of further error columns, which are reported if a grid has them for every design."""
Errors = dict[Design, float]


def assess_markers(evidence: Evidence) -> ClaimFinding:
    """Assess C9: errors fall with the number of markers, little above 91."""

    def test(errors: Errors) -> tuple[bool, str]:
        domes = [(height, thickness) for height in HEIGHTS for thickness in THICKNESSES]
        falls = sum(all(errors[*d, a] > errors[*d, b] for a, b in pairwise(MARKERS)) for d in domes)
        mean = {m: sum(errors[*dome, m] for dome in domes) / len(domes) for m in MARKERS}
        share = (mean[91] - mean[169]) / (mean[7] - mean[91]) if mean[7] != mean[91] else float("inf")
        text = f"falls on {falls} of {len(domes)} domes; mean {' / '.join(f'{mean[m]:.3f}' for m in MARKERS)}°, "
        text += f"the fall from 91 to 169 is {100 * share:.0f} % of that from 7 to 91"
        return falls >= MOSTLY * len(domes) and share < LITTLE, text

    return _decide(evidence, test)


def assess_best(evidence: Evidence) -> ClaimFinding:
    """Assess C10: the best design and its errors."""
    clean = evidence.figures(CLEAN)
    greatest = evidence.figures("max_error_deg", [BEST])[BEST]
    order = sorted(clean, key=lambda design: clean[design])
    figures = (
        f"{name_design(BEST)}: RMSE {clean[BEST]:.3f}°, maximum {greatest:.2f}°, rank {order.index(BEST) + 1} of "
        f"{len(order)}; best {name_design(order[0])}: {clean[order[0]]:.3f}°"
    )
    for column, words in NEIGHBOURS.items():
        if evidence.has(column):
            errors = evidence.figures(column)
            first = min(errors, key=lambda design: errors[design])
            figures += f"; {words} {errors[BEST]:.3f}°, best {name_design(first)}: {errors[first]:.3f}°"
    within = clean[BEST] <= PRINTED_RMSE_DEG and greatest <= PRINTED_MAX_DEG
    why = f"its errors are {'within' if within else 'above'} the published ones, {OF_PRINTED}"
    return ClaimFinding.of(order[0] == BEST and within, figures, why)


def assess_height(evidence: Evidence) -> ClaimFinding:
    """Assess C11: H = 20 mm beats H = 10 and 30 mm."""

    def test(errors: Errors) -> tuple[bool, str]:
        cases = [(t, m) for t in THICKNESSES for m in MARKERS]
        wins = sum(errors[20.0, t, m] < min(errors[10.0, t, m], errors[30.0, t, m]) for t, m in cases)
        means = (f"H{h:g} {sum(errors[h, t, m] for t, m in cases) / len(cases):.3f}°" for h in HEIGHTS)
        return wins >= MOSTLY * len(cases), f"smallest at H = 20 in {wins} of {len(cases)}; mean {', '.join(means)}"

    finding = _decide(evidence, test)
    low = [evidence.rows[design] for design in DESIGNS if design[0] == HEIGHTS[0]]
    dropped, samples = (sum(float(row[name] or 0) for row in low) for name in ("dropped", "samples"))
    if not dropped:
        return finding
    note = f"at H = 10 {100 * dropped / (dropped + samples):.0f} % of the images are unavailable (rim, branch)"
    return replace(finding, why="; ".join(part for part in (finding.why, note) if part))


def assess_thickness(evidence: Evidence) -> ClaimFinding:
    """Assess C12: thinner is more precise."""

    def test(errors: Errors) -> tuple[bool, str]:
        cases = [(h, m) for h in HEIGHTS for m in MARKERS]
        steps = [errors[h, a, m] < errors[h, b, m] for h, m in cases for a, b in pairwise(THICKNESSES)]
        means = (f"T{t:g} {sum(errors[h, t, m] for h, m in cases) / len(cases):.3f}°" for t in THICKNESSES)
        text = f"the thinner dome is better in {sum(steps)} of {len(steps)} steps; mean {', '.join(means)}"
        return sum(steps) >= MOSTLY * len(steps), text

    return _decide(evidence, test)


def assess_line(evidence: Evidence) -> ClaimFinding:
    """Assess C14: the maximum error is below the aerospace limit."""
    clean = evidence.figures("max_error_deg", [BEST])[BEST]
    jittered = evidence.figures("max_error_jitter_deg", [BEST])[BEST]
    there = [design for design in DESIGNS if design in evidence.rows]
    counts = []
    for column in ("max_error_deg", "max_error_jitter_deg"):
        cells = [evidence.rows[design].get(column) for design in there]
        counts.append(sum(isinstance(cell, int | float) and cell < AEROSPACE_LIMIT_DEG for cell in cells))
    figures = (
        f"{name_design(BEST)}: {clean:.2f}° clean, {jittered:.2f}° with jitter; below 2°: {counts[0]} of "
        f"{len(there)} designs clean, {counts[1]} with jitter"
    )
    for column, words in (("built_p95_deg", "as built"), ("calibrated_p95_deg", "after calibration presses")):
        if evidence.has(column):
            worst = evidence.figures(column)
            figures += f"; 95th percentile over units, {words}: {worst[BEST]:.2f}°, below 2°: "
            figures += f"{sum(error < AEROSPACE_LIMIT_DEG for error in worst.values())}"
    why = "" if jittered < AEROSPACE_LIMIT_DEG else "with the jitter of the training the error is above this limit"
    return ClaimFinding.of(clean < AEROSPACE_LIMIT_DEG, figures, why)


def name_design(design: Design) -> str:
    """Return the name of a design, e.g. ``"H20 T2 169"``."""
    return f"H{design[0]:g} T{design[1]:g} {design[2]}"


def _decide(evidence: Evidence, test: Callable[[Errors], tuple[bool, str]]) -> ClaimFinding:
    """Decide by the clean errors; report each further error column that would decide differently."""
    holds, text = test(evidence.figures(CLEAN))
    figures, why = [f"clean: {text}"], []
    for column, words in NEIGHBOURS.items():
        if column == JITTERED or evidence.has(column):
            beside, text = test(evidence.figures(column))
            figures.append(f"{words}: {text}")
            if beside != holds:
                why.append(f"{words} it {'holds' if beside else 'does not hold'}")
    return ClaimFinding.of(holds, "; ".join(figures), "; ".join(why))
