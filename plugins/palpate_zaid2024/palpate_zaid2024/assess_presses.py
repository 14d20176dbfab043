"""Claims about stress, deformation and marker travel: C3 to C8."""

from __future__ import annotations

from palpate_zaid2024.claim import MOSTLY, ClaimFinding, Verdict
from palpate_zaid2024.evidence import HEIGHTS, MARKERS, THICKNESSES, Dome, Evidence

TIE = 0.01
"""Relative difference below which two displacements count as equal."""
LARGEST_GAP_MM = 0.2
"""Gap between apex and wall below which a dome conforms to the wall."""
FLAT, RISE = 0.10, 0.05
"""Relative change of travel below which it counts as flat, and above which it counts as a rise."""


DOMES = [(height, thickness) for height in HEIGHTS for thickness in THICKNESSES]
"""Height and thickness (mm) of the paper's 12 domes."""
THICK, THIN = [(height, 2.0) for height in HEIGHTS], [(height, 1.0) for height in HEIGHTS]
"""Height and thickness (mm) of the domes of the paper's Fig. 10."""


def assess_stress(evidence: Evidence) -> ClaimFinding:
    """Assess C3: maximum stress at T = 2 mm falls with height."""
    straight = list(evidence.domes("peak_stress_straight_mpa", THICK).values())
    every = list(evidence.domes("peak_stress_mpa", THICK).values())
    figures = f"straight press {_by_height(straight)} MPa; any tilt {_by_height(every)} MPa"
    return ClaimFinding.of(straight[0] > straight[1] > straight[2], figures)


def assess_deformation(evidence: Evidence) -> ClaimFinding:
    """Assess C4: the hemisphere deforms most."""
    greatest = evidence.domes("displacement_max_mm", THIN + THICK)
    mean = evidence.domes("displacement_mean_straight_mm", THIN + THICK)
    wins, texts = [], []
    for domes in (THIN, THICK):
        low, middle, high = (greatest[dome] for dome in domes)
        low_mean, middle_mean, high_mean = (mean[dome] for dome in domes)
        wins.append(middle > (1 + TIE) * max(low, high) and middle_mean > max(low_mean, high_mean))
        texts.append(
            f"T = {domes[0][1]:g}: maximum displacement in any press {_by_height([low, middle, high])} mm, mean "
            f"over the dome in the straight press {_by_height([low_mean, middle_mean, high_mean])} mm"
        )
    return ClaimFinding.of(all(wins), "; ".join(texts))


def assess_inversion(evidence: Evidence) -> ClaimFinding:
    """Assess C5: T = 2 mm conforms, T = 1 mm inverts, more so at steeper angles."""
    branches = evidence.branches(THIN + THICK)
    gap = max(evidence.domes("apex_gap_mm", THICK).values())
    thin = [pair for dome in THIN for pair in branches[dome]]
    thick = [branch for dome in THICK for _, branch in branches[dome]]
    inverted = sum(branch == "inverted" for _, branch in thin)
    conforms = "inverted" not in thick and gap < LARGEST_GAP_MM
    figures = (
        f"inverted at full depth: {inverted} of {len(thin)} presses at T = 1, "
        f"{thick.count('inverted')} of {len(thick)} at T = 2; apex at most {gap:.2g} mm from the wall at T = 2"
    )
    both = [_bistable(evidence, domes) for domes in (THIN, THICK)]
    figures += f"; inverted branch in the straight press: T = 1 {both[0]}; T = 2 {both[1]}"
    if inverted:
        middle = sorted(tilt for tilt, _ in thin)[len(thin) // 2]
        steep = [branch == "inverted" for tilt, branch in thin if tilt >= middle]
        gentle = [branch == "inverted" for tilt, branch in thin if tilt < middle]
        steeper = sum(steep) / len(steep) > (sum(gentle) / len(gentle) if gentle else 0.0)
        return ClaimFinding.of(conforms and steeper, figures)
    if conforms and "from" in both[0]:
        return ClaimFinding(
            Verdict.UNDECIDED,
            figures,
            "T = 1 mm stays on the flat branch, although an inverted branch exists: without slip it needs no pull, "
            "without friction a pull below 0.3 kPa; the branch of a real dome depends on the wall, "
            "on shocks and on flaws, which the paper does not give",
        )
    return ClaimFinding.of(False, figures)


def assess_travel_by_markers(evidence: Evidence) -> ClaimFinding:
    """Assess C6: travel is lowest with 7 markers and highest with 169, and above 1 mm with more than 7."""
    domes = [dome for dome in DOMES if all((*dome, markers) in evidence.rows for markers in MARKERS)]
    travel = evidence.figures("travel_mm", [(*dome, markers) for dome in domes for markers in MARKERS])
    lowest = sum(travel[*dome, 7] == min(travel[*dome, m] for m in MARKERS) for dome in domes)
    highest = sum(travel[*dome, 169] == max(travel[*dome, m] for m in MARKERS) for dome in domes)
    above = sum(min(travel[*dome, m] for m in MARKERS[1:]) > 1.0 for dome in domes)
    holds = lowest == highest == above == len(domes)
    if holds:  # the claim needs all domes; one counterexample refutes it
        evidence.figures("travel_mm")
    means = ", ".join(f"{m}: {sum(travel[*dome, m] for dome in domes) / len(domes):.2f}" for m in MARKERS)
    figures = (
        f"7 lowest on {lowest} of {len(domes)} domes, 169 highest on {highest}, all but 7 above 1 mm on {above}; "
        f"mean over the domes {means} mm"
    )
    return ClaimFinding.of(holds, figures)


def assess_travel_by_height(evidence: Evidence) -> ClaimFinding:
    """Assess C7: travel is largest at H = 20 mm."""
    travel = evidence.figures("travel_mm")
    cases = [(t, m) for t in THICKNESSES for m in MARKERS]
    wins = sum(travel[20.0, t, m] > max(travel[10.0, t, m], travel[30.0, t, m]) for t, m in cases)
    means = [sum(travel[height, t, m] for t, m in cases) / len(cases) for height in HEIGHTS]
    figures = f"largest at H = 20 in {wins} of {len(cases)}; mean {_by_height(means)} mm"
    return ClaimFinding.of(wins >= MOSTLY * len(cases), figures)


def assess_travel_by_thickness(evidence: Evidence) -> ClaimFinding:
    """Assess C8: travel is flat over thickness at H = 10 mm; at 20 and 30 mm it rises fast, then slowly."""
    travel = evidence.figures("travel_mm")
    mean = {h: [sum(travel[h, t, m] for m in MARKERS) / len(MARKERS) for t in THICKNESSES] for h in HEIGHTS}
    flat = all(abs(value / mean[10.0][0] - 1.0) < FLAT for value in mean[10.0])
    rises = []
    for height in (20.0, 30.0):
        steps = [after - before for before, after in zip(mean[height], mean[height][1:], strict=False)]
        rises.append(steps[0] > RISE * mean[height][0] and steps[0] > max(steps[1:]))
    texts = [f"H{h:g} {' / '.join(f'{value:.2f}' for value in mean[h])}" for h in HEIGHTS]
    return ClaimFinding.of(flat and all(rises), f"mean travel at T = 1 / 2 / 3 / 4: {'; '.join(texts)} mm")


def _by_height(values: list[float]) -> str:
    return ", ".join(f"H{height:g} {value:.3g}" for height, value in zip(HEIGHTS, values, strict=True))


def _bistable(evidence: Evidence, domes: list[Dome]) -> str:
    depths = evidence.domes_or_none("bistable_from_mm", domes)
    found = [f"H{height:g} from {depth:.2g} mm" for (height, _), depth in depths.items() if depth is not None]
    return ", ".join(found) or "none"
