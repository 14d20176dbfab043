"""Controls of the learning on real presses: what a split by image flatters, shuffled labels, intervals on new poses.

    palpate run studies/first.yaml --out results/first
    python benchmarks/controls.py studies/first.yaml results/first

Nothing of this enters a grid.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.core import ArtefactStore, generator
from palpate.datasets import Dataset, DatasetSpec, draw_jitter, generate_dataset
from palpate.fea import read_press
from palpate.learn import (
    Estimator,
    TrainingSpec,
    calibrate_interval,
    compare_splits,
    evaluate,
    measure_coverage,
    shuffle_labels,
    train,
)
from palpate.study import read_study
from palpate.study.plan import plan_study
from palpate.study.task import DatasetTask, find_artefact

EARLY = TrainingSpec(schedule="plateau", stopping_patience=10, plateau_patience=5)
"""As `quick`, but stopped by the held-out presses, as the paper stops."""
TRAINED_TO_DEG = 9.0


def make(task: DatasetTask, store: ArtefactStore, spec: DatasetSpec) -> Dataset:
    presses = [read_press(find_artefact(store, press)) for press in task.presses]
    return generate_dataset(presses, task.design.layout, task.design.camera, spec)


def print_splits(task: DatasetTask, store: ArtefactStore) -> None:
    print("| poses | split by press: RMSE / max | split by image: RMSE / max | flatters |\n|---|---|---|---|")
    specs = {
        "1200 over the disc": DatasetSpec(),
        "91 over the disc": DatasetSpec(n_presses=91),
        "the paper's 91": DatasetSpec(poses="paper-91"),
    }
    for name, spec in specs.items():
        found = compare_splits(make(task, store, spec), TrainingSpec(), seed=1)
        errors = (f"{part.rmse_deg:.3f} / {part.max_error_deg:.2f}" for part in (found.by_press, found.by_image))
        print(f"| {name} | {' | '.join(errors)} | {found.optimism_factor:.2f} |", flush=True)


def print_shuffled(dataset: Dataset) -> None:
    shuffled = shuffle_labels(dataset, seed=1)
    spread = float(np.sqrt((shuffled.subset(validation=True).poses[:, :2] ** 2).mean()))
    for name, spec in (("stopped early", EARLY), ("quick", TrainingSpec())):
        rmse = evaluate(train(shuffled, spec, 1), shuffled).rmse_deg
        print(
            f"shuffled labels, {name}: RMSE {rmse:.3f}°, spread {spread:.3f}°, ratio {rmse / spread:.3f}", flush=True
        )


def print_intervals(estimator: Estimator, dataset: Dataset, fresh: Dataset) -> None:
    own = measure_coverage(estimator, dataset, seed=2)
    assert estimator.interval is not None
    elsewhere = replace(estimator, interval=replace(estimator.interval, presses=()))
    everything = replace(fresh, validation=np.ones(len(fresh.poses), dtype=bool))
    for name, found in (
        ("its own other presses", own),
        ("new poses", measure_coverage(elsewhere, everything, seed=2)),
    ):
        assert found is not None
        print(
            f"coverage on {name}: {found.presses} presses, angle {100 * found.angle:.1f} %, depth "
            f"{100 * found.depth:.1f} %, half-width {found.half_width_deg:.2f}°, called outside "
            f"{100 * found.flagged_ood:.1f} %",
            flush=True,
        )


def print_outside(dataset: Dataset) -> None:
    """Images that the training did not know, from a training on tilts up to `TRAINED_TO_DEG`, depths above 3 mm."""
    tilt, depth = np.hypot(dataset.poses[:, 0], dataset.poses[:, 1]), dataset.poses[:, 2]
    estimator = train(keep(dataset, (tilt < TRAINED_TO_DEG) & (depth > 3.0)), TrainingSpec(), 1)
    estimator = calibrate_interval(estimator, keep(dataset, (tilt < TRAINED_TO_DEG) & (depth > 3.0)), 1)
    noisy = draw_jitter(dataset.images_px, dataset.spec.jitter_px, generator(3))
    swapped, lost = noisy.copy(), noisy.copy()
    swapped[:, [1, 2]] = noisy[:, [2, 1]]
    lost[:, 3] += 10.0
    known = (tilt < TRAINED_TO_DEG) & (depth > 3.0) & dataset.validation
    cases = {
        "as trained": noisy[known],
        "at rest": draw_jitter(np.tile(dataset.rest_px, (500, 1, 1)), dataset.spec.jitter_px, generator(4)),
        "2.4 mm deep": noisy[(tilt < TRAINED_TO_DEG) & (depth < 3.0)],
        "11 to 12 degrees, 4 mm": noisy[(tilt > 11) & np.isclose(depth, 4.0)],
        "11 to 12 degrees, 8 mm": noisy[(tilt > 11) & np.isclose(depth, 8.0)],
        "two markers swapped": swapped[known],
        "a marker 10 px off": lost[known],
    }
    for name, images in cases.items():
        print(
            f"called outside, {name}: {100 * estimator.estimate(images).out_of_distribution.mean():.1f} %", flush=True
        )


def keep(dataset: Dataset, rows: NDArray[np.bool_]) -> Dataset:
    names = ("images_px", "poses", "press", "validation", "branch", "travel_mm")
    return replace(dataset, **{name: getattr(dataset, name)[rows] for name in names})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("results", type=Path)
    parser.add_argument("--markers", type=int, nargs="+", default=[169])
    words = parser.parse_args()
    store = ArtefactStore(words.results / "store")
    for design in plan_study(read_study(words.study)).designs:
        task = design.dataset
        skin, count = task.design.skin, len(task.design.layout)
        if (skin.height, skin.thickness) != (20.0, 2.0) or count not in words.markers:
            continue
        print(f"\nH20 T2, {count} markers")
        dataset = make(task, store, DatasetSpec())
        estimator = calibrate_interval(train(dataset, TrainingSpec(), 1), dataset, 1)
        print_intervals(estimator, dataset, make(task, store, DatasetSpec(seed=77)))
        print_outside(dataset)
        print_shuffled(dataset)
        print_splits(task, store)


if __name__ == "__main__":
    main()
