"""Predicted errors of modes that were not measured, by leaving one rubber out of five.

Every model is fitted to one mode of a rubber, and to two, and judged on the modes left as far as its prediction goes
(the stretch of the greatest I1 measured). Errors beyond 500 % count as 500 %. The constants of the prediction are
chosen on four rubbers and scored on the fifth; the shipped ones and the prediction before are scored beside.

    python benchmarks/unseen_modes.py docs/results/materials/unseen_modes.csv
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import numpy as np

from palpate.material import Loading, Sample, extrapolate_modes, rank, rank_models
from palpate.verify.read_reference import read_reference

DATA = Path(__file__).parents[1] / "tests" / "unit" / "material" / "data"
TESTS = {"UT": "uniaxial", "UC": "uniaxial", "ET": "equibiaxial", "PS": "planar"}
RUBBERS = ("treloar_1944", "meunier_2008", "kawabata_1981", "james_1975", "kawamura_2001")
CAP = 5.0
SHARES, FLOORS = (0.5, 0.7, 1.0, 1.4, 2.0), (0.03, 0.05, 0.07, 0.1, 0.13, 0.15, 0.2)
QUANTILE = 0.975
_BEFORE = 3.0


def read_rubber(name: str) -> dict[str, Sample]:
    """Samples of a rubber by mode, without the row at rest."""
    found = {}
    if name == "treloar_1944":
        table = read_reference("treloar_data").where(digitisation="B")
        for mode in ("uniaxial", "equibiaxial", "planar"):
            rows = table.where(mode=mode)
            found[mode] = Sample(mode, Loading(mode), rows["stretch"], rows["nominal_stress_MPa"])
        return found
    for path in sorted((DATA / name).glob("*_stress_stretch.txt")):
        stress, stretch = np.loadtxt(path).T
        moved = np.abs(stretch - 1) > 1e-9
        mode = TESTS[path.name[:2]]
        found[mode] = Sample(mode, Loading(mode), stretch[moved], stress[moved])
    return found


def measure(name: str) -> list[tuple[str, float, float, float]]:
    """Rubber, median distance between models, the same by the peers taken before, and true error of every fit."""
    samples, rows = read_rubber(name), []
    for count in (1, 2):
        for seen in itertools.combinations(samples, count):
            given = [samples[mode] for mode in seen]
            if len(seen) == len(samples) or min(len(sample.stretch) for sample in given) < 4:
                continue
            ranked = rank_models(given)
            for fit in (item.fit for item in ranked if item.fit is not None):
                found = []
                for rank._AS_GOOD in (_BEFORE, 10.0):
                    found.append(extrapolate_modes(fit, ranked, given))
                for before, now in zip(*found, strict=True):
                    other = samples.get(str(now.mode))
                    if other is None:
                        continue
                    reached = other.where(other.stretch <= now.high)
                    with np.errstate(over="ignore", invalid="ignore"):
                        error = fit.nominal_of(reached) - reached.nominal
                    true = float(np.sqrt(np.mean(error**2)) / np.abs(reached.nominal).max())
                    rows.append((name, now.between, before.between, true))
    return rows


def main() -> None:
    rows = [row for name in RUBBERS for row in measure(name)]
    rubber = np.array([row[0] for row in rows])
    between, before, true = np.minimum(np.array([row[1:] for row in rows]).T, CAP)
    known = np.isfinite(between)

    def share_within(predicted: np.ndarray, chosen: np.ndarray) -> float:
        return float(np.mean(np.abs(np.log(true[chosen] / predicted[chosen])) < np.log(4)))

    def predict(share: float, floor: float) -> np.ndarray:
        return np.minimum(np.hypot(share * between, floor), CAP)

    def goodness(share: float, floor: float, names: list[str]) -> float:
        ratio = [np.log(true / predict(share, floor))[known & (rubber == name)] for name in names]
        return float(np.mean([np.mean(np.abs(q) < np.log(4)) - 0.1 * np.mean(np.abs(q)) for q in ratio]))

    lines = [
        "rubber,fits,unknown,before_within_4,share,floor,upper_factor,within_4,below_upper,shipped_within_4,shipped_below_upper"
    ]
    hits = []
    for name in RUBBERS:
        others = [other for other in RUBBERS if other != name]
        share, floor = max(itertools.product(SHARES, FLOORS), key=lambda c: goodness(*c, others))
        ratio = true / predict(share, floor)
        upper = float(np.mean([np.quantile(ratio[known & (rubber == other)], QUANTILE) for other in others]))
        here = known & (rubber == name)
        shipped = predict(rank._SHARE, rank._BENCHES)
        old = (rubber == name) & np.isfinite(before)
        values = (
            share_within(before, old),
            share_within(predict(share, floor), here),
            float(np.mean(ratio[here] <= upper)),
            share_within(shipped, here),
            float(np.mean(true[here] <= rank._UPPER * shipped[here])),
        )
        hits.append((old.sum(), *[here.sum()] * 4, *values))
        lines.append(
            f"{name},{here.sum()},{(rubber == name).sum() - here.sum()},{values[0]:.3f},{share},{floor},{upper:.2f},"
            + ",".join(f"{value:.3f}" for value in values[1:])
        )
    table = np.array(hits)
    mean = (table[:, :5] * table[:, 5:]).sum(axis=0) / table[:, :5].sum(axis=0)
    lines.append(f"all,{known.sum()},{(~known).sum()},{mean[0]:.3f},,,," + ",".join(f"{v:.3f}" for v in mean[1:]))
    text = "\n".join(lines) + "\n"
    Path(sys.argv[1]).write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
