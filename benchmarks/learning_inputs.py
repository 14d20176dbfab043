"""What should a network read? The same images, split and network; inputs, ring sets and closed forms change.

    palpate run studies/first.yaml --out results/first
    python benchmarks/learning_inputs.py studies/first.yaml results/first --out learning_inputs.csv

Errors are of the angle on held-out presses: clean RMSE and greatest error, and RMSE of one draw of the jitter.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.core import ArtefactStore, child_seed, generator
from palpate.datasets import Dataset, draw_jitter, read_dataset, split_presses
from palpate.learn import Metrics, TrainingSet, TrainingSpec, fit_ridge, measure_errors
from palpate.learn.components import PrincipalComponents, find_components
from palpate.learn.network import collect_layers, train_network
from palpate.learn.perceptron import evaluate_perceptrons
from palpate.study import read_study
from palpate.study.plan import plan_study
from palpate.study.task import find_artefact

Array = NDArray[np.float64]
Predict = Callable[[Array], Array]

SEED = 0
KERNEL_IMAGES = 4000
LENGTHS, PENALTIES = (1.5, 3.0, 6.0, 12.0), (1e-4, 1e-3, 1e-2, 1e-1)
"""Length scales (in units of the whitened components' spread) and penalties among which kernel regression chooses."""
COLUMNS = ("markers", "input", "clean_rmse_deg", "clean_max_deg", "jittered_rmse_deg", "seconds")


def normalised(dataset: Dataset, images_px: Array) -> Array:
    return dataset.normalisation.apply(images_px).reshape(len(images_px), -1)


def jitter_of(dataset: Dataset) -> Array:
    return np.tile(dataset.spec.jitter_px / np.array(dataset.normalisation.scale_px), dataset.images_px.shape[1])


def positions(dataset: Dataset, clean: Array) -> PrincipalComponents:
    """Normalised positions as the paper has them."""
    return PrincipalComponents(np.zeros(clean.shape[1]), np.eye(clean.shape[1]))


def displacements(dataset: Dataset, clean: Array) -> PrincipalComponents:
    """Normalised positions less those at rest."""
    return PrincipalComponents(normalised(dataset, dataset.rest_px[None])[0], np.eye(clean.shape[1]))


def standardised(dataset: Dataset, clean: Array) -> PrincipalComponents:
    """Every coordinate less its mean, over the root of its variance with jitter."""
    sd = np.sqrt(clean.var(axis=0) + jitter_of(dataset) ** 2 / 3)
    return PrincipalComponents(clean.mean(axis=0), np.diag(1.0 / sd))


def whitened(count: int) -> Callable[[Dataset, Array], PrincipalComponents]:
    """Leading principal components over the root of signal and jitter."""

    def choose(dataset: Dataset, clean: Array) -> PrincipalComponents:
        noise, covariance = float(np.mean(jitter_of(dataset) ** 2)) / 3, np.cov(clean, rowvar=False)
        return find_components(clean.mean(axis=0), covariance, count, lambda variance: np.sqrt(variance + noise))

    return choose


INPUTS: dict[str, Callable[[Dataset, Array], PrincipalComponents]] = {
    "positions": positions,
    "displacement from rest": displacements,
    "displacement, standardised": standardised,
    "12 components": whitened(12),
    "24 components": whitened(24),
    "48 components": whitened(48),
    "96 components": whitened(96),
}


def learn_network(dataset: Dataset, choose: Callable[[Dataset, Array], PrincipalComponents]) -> Predict:
    """The network of the preset `quick` on other inputs."""
    spec, kept = TrainingSpec(), dataset.subset(validation=False)
    inputs = normalised(dataset, kept.images_px)
    components = choose(dataset, inputs)
    every = np.ones(len(inputs), bool)
    samples = TrainingSet(inputs, kept.poses, every, np.arange(len(inputs)) == 0, SEED)
    mean, sd = samples.scale
    trained = train_network(samples, jitter_of(dataset), components, spec)
    weights, biases = collect_layers(trained)

    def predict(images_px: Array) -> Array:
        features = (normalised(dataset, images_px) - components.mean) @ components.projection
        outputs = evaluate_perceptrons(features, weights, biases, spec.activation)
        return np.asarray(outputs.mean(axis=0) * sd + mean)

    return predict


def fit_kernel(dataset: Dataset, kept: Dataset, length: float, penalty: float) -> Predict:
    """Kernel ridge regression, Gaussian kernel on 48 whitened components of jittered and clean training images."""
    rng = generator(SEED, "kernel")
    components = whitened(48)(dataset, normalised(dataset, kept.images_px))
    rows = rng.permutation(np.tile(np.arange(len(kept.poses)), 2))[:KERNEL_IMAGES]
    images = draw_jitter(kept.images_px[rows], dataset.spec.jitter_px, rng)
    clean = rng.random(len(rows)) < TrainingSpec().clean_share
    images[clean] = kept.images_px[rows][clean]

    def read(images_px: Array) -> Array:
        found: Array = (normalised(dataset, images_px) - components.mean) @ components.projection
        return found

    def kernel(first: Array, second: Array) -> Array:
        square = (first**2).sum(axis=1)[:, None] + (second**2).sum(axis=1) - 2.0 * first @ second.T
        found: Array = np.exp(-np.maximum(square, 0.0) / (2.0 * length**2))
        return found

    mean, sd = kept.poses.mean(axis=0), kept.poses.std(axis=0)
    support = read(images)
    gram = kernel(support, support)
    gram[np.diag_indices_from(gram)] += penalty
    weight = np.linalg.solve(gram, (kept.poses[rows] - mean) / sd)
    return lambda images_px: kernel(read(images_px), support) @ weight * sd + mean


def learn_kernel(dataset: Dataset, by_jitter: bool) -> Predict:
    """Length and penalty chosen on presses taken from those for training, as `best` chooses or by jitter alone."""
    kept = dataset.subset(validation=False)
    held = split_presses(kept.press, child_seed(SEED, "inner"), 0.2).validation
    inner = replace(kept, validation=held)
    scores = {}
    for length in LENGTHS:
        for penalty in PENALTIES:
            predict = fit_kernel(dataset, inner.subset(validation=False), length, penalty)
            clean, jittered = judge(inner, predict)
            scores[length, penalty] = jittered.rmse_deg * (1.0 if by_jitter else clean.rmse_deg)
    best = min(scores, key=lambda pair: scores[pair])
    print(f"    kernel: length {best[0]:g}, penalty {best[1]:g}")
    return fit_kernel(dataset, kept, *best)


def judge(dataset: Dataset, predict: Predict) -> tuple[Metrics, Metrics]:
    """Errors on the held-out presses, clean and with jitter."""
    held = dataset.subset(validation=True)
    noisy = draw_jitter(held.images_px, dataset.spec.jitter_px, generator(SEED, "judge"))
    return measure_errors(predict(held.images_px), held.poses), measure_errors(predict(noisy), held.poses)


def keep_markers(dataset: Dataset, chosen: NDArray[np.bool_]) -> Dataset:
    return replace(dataset, images_px=dataset.images_px[:, chosen], rest_px=dataset.rest_px[chosen])


def ring_sets(dataset: Dataset) -> Iterator[tuple[str, Dataset]]:
    """Rings of the layout by their size in the image at rest, the smallest first."""
    centre = dataset.rest_px.mean(axis=0)
    radius = np.linalg.norm(dataset.rest_px - centre, axis=1)
    steps = np.sort(radius)
    edges = steps[1:][np.diff(steps) > 0.3 * np.diff(steps).max()]
    ring = np.searchsorted(edges, radius, side="right")
    count = int(ring.max()) + 1
    sets = {
        "inner half of the rings": ring < count / 2,
        "outer half of the rings": ring >= count / 2,
        "every second ring": ring % 2 == 0,
        "the outermost ring": ring == count - 1,
    }
    for name, chosen in sets.items():
        yield f"{name} ({chosen.sum()} markers)", keep_markers(dataset, chosen)


def cases(dataset: Dataset) -> Iterator[tuple[str, Dataset, Callable[[], Predict]]]:
    for name, choose in INPUTS.items():
        yield name, dataset, lambda choose=choose: learn_network(dataset, choose)
    yield "ridge regression", dataset, lambda: fit_ridge(dataset).predict
    yield "kernel regression, chosen as by `best`", dataset, lambda: learn_kernel(dataset, False)
    yield "kernel regression, chosen by the jittered error", dataset, lambda: learn_kernel(dataset, True)
    if len(dataset.rest_px) > 7:
        for name, part in ring_sets(dataset):
            yield name, part, lambda part=part: learn_network(part, whitened(48))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("results", type=Path)
    parser.add_argument("--height", type=float, default=20.0)
    parser.add_argument("--thickness", type=float, default=2.0)
    parser.add_argument("--markers", type=int, nargs="+", default=[37, 169])
    parser.add_argument("--only", default="", help="cases whose name holds this word")
    parser.add_argument("--out", type=Path, required=True)
    words = parser.parse_args()
    store = ArtefactStore(words.results / "store")
    tasks = [design.dataset for design in plan_study(read_study(words.study)).designs]
    rows = []
    for task in tasks:
        if (task.design.skin.height, task.design.skin.thickness) != (words.height, words.thickness):
            continue
        count = len(task.design.layout)
        if count not in words.markers:
            continue
        whole = read_dataset(find_artefact(store, task))
        for name, dataset, learn in cases(whole):
            if words.only not in name:
                continue
            started = time.process_time()
            clean, jittered = judge(dataset, learn())
            seconds = time.process_time() - started
            rows.append((count, name, clean.rmse_deg, clean.max_error_deg, jittered.rmse_deg, seconds))
            print(
                f"| {count} | {name} | " + " | ".join(f"{value:.3f}" for value in rows[-1][2:5]),
                end="",
            )
            print(f" | {seconds:.0f} |", flush=True)
    with words.out.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows([[f"{cell:.4g}" if isinstance(cell, float) else cell for cell in row] for row in rows])


if __name__ == "__main__":
    main()
