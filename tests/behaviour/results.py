"""Comparison of the reference results with the stored ones, and renewal of the stored ones."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from behaviour.cases import CASES, ROUNDING
from palpate.core.behaviour import BEHAVIOUR_FILE

STORED = {
    "press": {
        "by curvature": "by bend",
        "by lateral_rate": "by drift",
        "by lateral_rate_across": "by drift_across",
    },
    "accuracy": {"calibration_presses": "known", "p95_deg": "worst_deg"},
    "unit_trial": {
        "inverse_friction": "slip",
        "inverse_friction_read": "slip_read",
        "inverse_friction_half": "slip_half",
    },
}
"""Stage → name of a result → its name in the stored file, which keeps the names of 0.2 and so its stamps."""
DIGITS, SHARE = 7, 1e-5
"""Significant digits that are stored, and the share of a result's size below which two results are equal."""


def compute(stage: str) -> dict[str, Any]:
    """Results of a stage: case → name → flat list of numbers."""
    return {
        case: {
            STORED.get(stage, {}).get(name, name): [_round(value) for value in np.ravel(np.asarray(values, float))]
            for name, values in found.items()
        }
        for case, found in CASES[stage]().items()
    }


def compare(stage: str, stored: dict[str, Any], found: dict[str, Any]) -> list[str]:
    """Names of results that differ beyond rounding, with the largest difference."""
    if stored.keys() != found.keys():
        return [f"{stage}: cases {sorted(stored.keys() ^ found.keys())}"]
    faults = []
    for case, results in found.items():
        for name in sorted(results.keys() | stored[case].keys()):
            old, new = (np.array(one.get(name, []), float) for one in (stored[case], results))
            if old.shape != new.shape or not np.array_equal(np.isfinite(old), np.isfinite(new)):
                faults.append(f"{stage}, {case}, {name}: {old.shape} values, now {new.shape}")
                continue
            difference = np.nanmax(np.abs(new - old), initial=0.0)
            if difference > ROUNDING.get(f"{stage}, {case}", ROUNDING.get(stage, SHARE)) * np.nanmax(
                np.abs(old), initial=0.0
            ):
                faults.append(f"{stage}, {case}, {name}: {difference:.3g} of {np.nanmax(np.abs(old)):.3g}")
    return faults


def _round(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None


def renew(stages: list[str]) -> None:
    """Write new results of stages, all if none is named; a stage whose results agree keeps them and its stamp."""
    stored = json.loads(BEHAVIOUR_FILE.read_text()) if BEHAVIOUR_FILE.exists() else {}
    _write({stage: stored.get(stage, {}) for stage in CASES})  # stages ask for the stamps of all
    for stage in stages or CASES:
        found = compute(stage)
        if stage not in stored or compare(stage, stored[stage], found):
            stored[stage] = found
    _write({stage: stored[stage] for stage in CASES})


def _write(results: dict[str, Any]) -> None:
    """Write the file with a line for each result."""
    text = json.dumps(results, separators=(",", ":"))
    BEHAVIOUR_FILE.write_text(text.replace('],"', '],\n"').replace('},"', '},\n"') + "\n")


if __name__ == "__main__":
    renew(sys.argv[1:])
