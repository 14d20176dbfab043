"""Hold the search of skins against chance at equal cost, on real presses, seed by seed.

    python benchmarks/search_against_chance.py FOLDER RESULTS.csv [SKINS]

The paper's task by error alone, its camera at 30 mm, where every skin reads best; 24 skins by the search and 24 by
chance unless said otherwise, all judged by the same coarse presses. The first eight of both are the same: before that
the search has nothing to go by. Units, poses and known presses are drawn by the seed, alike for both. Every seed has
its folder and is a row once it is finished, so a stopped run goes on where it was.
"""

import csv
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from palpate.cli.progress import TerminalProgress
from palpate.optimise import Front, RequirementsSpec, SkinTrial, optimise_design, read_requirements
from palpate.optimise.draw_front import draw_search
from palpate.optimise.front import coarse_errors

SEEDS, SKINS, DISTANCE = range(5), 24, 30.0
COLUMNS = ["seed", "skins", "search_deg", "chance_deg", "search_rmse_deg", "chance_rmse_deg", "as_good_after"]
COLUMNS += ["search_within_limits", "chance_within_limits", "search_skin", "chance_skin"]


def task(seed: int, skins: int) -> RequirementsSpec:
    """The requirements of one seed."""
    wanted = read_requirements("paper_task")
    camera = wanted.cameras[0].model_copy(update={"distances": (DISTANCE, DISTANCE)})
    other = {"seed": seed, "skins": skins, "random_skins": skins, "cameras": (camera,), "objectives": ("error",)}
    return wanted.model_copy(
        update={**other, "finalists": 0, "baseline_grid": None, "baseline": None, "max_hours": 1e4}
    )


def least_so_far(tried: Sequence[SkinTrial], markers: int) -> np.ndarray:
    """Least error (n,) of 19 of 20 units among the first skins that meet the limits, degrees."""
    errors = dict(coarse_errors(tried, markers, meets=True))
    return np.minimum.accumulate([errors.get(one.number, np.inf) for one in tried])


def compare(front: Front) -> list[object]:
    """One row: the best of both, and after how many skins the search was as good as the best by chance."""
    most, parts = front.spec.markers, (front.trials, front.search_baselines.random)
    search, chance = (least_so_far(part, most) for part in parts)
    best = [part[int(np.argmax(least == least[-1]))] for part, least in zip(parts, (search, chance), strict=True)]
    rmse = [one.coarse.best(most).accuracy.rmse_deg for one in best]
    after = int(np.argmax(search <= chance[-1])) + 1 if search[-1] <= chance[-1] else 0
    figures = [round(float(value), 5) for value in (search[-1], chance[-1], *rmse)]
    meets = [sum(one.feasible for one in part) for part in parts]
    return [front.spec.seed, len(search), *figures, after, *meets, *(one.coarse.skin.build().name for one in best)]


def main(folder: Path, results: Path, skins: int = SKINS) -> None:
    """Run the seeds that have no row yet."""
    rows = list(csv.reader(results.open()))[1:] if results.exists() else []
    for seed in SEEDS:
        if str(seed) in {row[0] for row in rows}:
            continue
        front = optimise_design(task(seed, skins), folder / f"seed{seed}", progress=TerminalProgress(live=False))
        draw_search(front).savefig(folder / f"seed{seed}" / "search.svg")
        rows.append([str(value) for value in compare(front)])
        with results.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
        print(dict(zip(COLUMNS, rows[-1], strict=True)), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), *map(int, sys.argv[3:]))
