"""Readings of the learning protocol of Zaid et al. 2024, each trained: which gives its 0.3° and 0.8°?

    python benchmarks/paper_protocol.py docs/results/paper_protocol.csv

What the text leaves open is chosen anew in each reading (split, jitter, azimuths, images, contact, what one input
is); the rest is as printed: Adam at 1e-4, stop after 75 epochs, three trainings of which the best in validation is
kept. Rows that stand in the file are not trained again. One thread.
"""

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.camera import build_camera
from palpate.core import generator
from palpate.datasets import DatasetSpec, generate_dataset
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.learn import TrainingSet, paper_training
from palpate.learn.components import PrincipalComponents
from palpate.learn.network import collect_layers, train_network
from palpate.learn.perceptron import evaluate_perceptrons
from palpate.material import get_material
from palpate.mesh import mesh_skin

TILTS = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0)
COPIES = 16
"""Noisy copies of each image where the jitter is not one that training draws by itself."""


@dataclass(frozen=True)
class Reading:
    """One way to read the text.

    Attributes
    ----------
    name
        What is chosen.
    contact
        Law of the presses.
    poses
        Azimuths: ``"paper-91"`` to 60°, ``"paper-504"`` all round.
    split
        By ``"press"`` or by ``"image"``.
    jitter
        Of training: ``"none"``, ``"fresh"`` (each coordinate, anew each epoch), ``"once"`` (drawn before all),
        ``"disc"`` (a length of 2 px at most), ``"shift"`` (all markers alike).
    judged
        Whether validation images have that jitter or are ``"clean"``.
    dropped
        Images after rest that are left out.
    whole
        Whether one input is all images of a press.
    layers, width
        Of the network.
    """

    name: str
    contact: str = "no-slip"
    poses: str = "paper-91"
    split: str = "press"
    jitter: str = "fresh"
    judged: str = "jittered"
    dropped: int = 2
    whole: bool = False
    layers: int = 3
    width: int = 512


READINGS = (
    Reading("as settled: split by press, jitter in both"),
    Reading("validation clean", judged="clean"),
    Reading("no jitter", jitter="none", judged="clean"),
    Reading("jitter drawn once", jitter="once"),
    Reading("split by image", split="image"),
    Reading("split by image, validation clean", split="image", judged="clean"),
    Reading("split by image, jitter drawn once", split="image", jitter="once"),
    Reading("jitter of 2 px length at most", jitter="disc"),
    Reading("jitter as a shift of the image", jitter="shift"),
    Reading("azimuths all round", poses="paper-504"),
    Reading("azimuths all round, split by image, validation clean", poses="paper-504", split="image", judged="clean"),
    Reading("the last image alone", dropped=9),
    Reading("the last three images", dropped=7),
    Reading("a press as one input", whole=True),
    Reading("a press as one input, azimuths all round", whole=True, poses="paper-504"),
    Reading("frictionless", contact="frictionless"),
    Reading("frictionless, validation clean", contact="frictionless", judged="clean"),
    Reading("frictionless, the last image alone", contact="frictionless", dropped=9),
    Reading("frictionless, a press as one input", contact="frictionless", whole=True),
    Reading("the deeper half of the images", dropped=5),
    Reading("the deepest image, azimuths all round", poses="paper-504", dropped=9),
    Reading("the deepest image, azimuths all round, split by image", poses="paper-504", dropped=9, split="image"),
    Reading("frictionless, the last three images", contact="frictionless", dropped=7),
    Reading("network of 5 layers of 1024", layers=5, width=1024),
    Reading("network of 2 layers of 128", layers=2, width=128),
)


def solve(contact):
    skin, law = build_skin(DomeSpec()), get_material("zaid_2024_ecoflex_00_30")
    walls = [WallSpec(tilt_deg=tilt, depth=8.0, depth_step=0.8, contact=contact) for tilt in TILTS]
    return skin, [solve_press(mesh_skin(skin), law, wall) for wall in walls]


def draw(kind, shape, rng):
    """Pixels (n, m, 2) of jitter."""
    count, markers, _ = shape
    if kind == "none":
        return np.zeros(shape)
    if kind == "disc":
        angle, radius = (
            rng.uniform(0, 2 * np.pi, (count, markers)),
            2.0 * np.sqrt(rng.uniform(0, 1, (count, markers))),
        )
        return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    if kind == "shift":
        return np.broadcast_to(rng.uniform(-2, 2, (count, 1, 2)), shape)
    return rng.uniform(-2.0, 2.0, shape)


def gather(dataset, whole):
    """Images (n, m, 2), angles (n, 2) and press (n,): of every image, or with all images of a press side by side."""
    if not whole:
        return dataset.images_px, dataset.poses[:, :2], dataset.press
    presses, counts = np.unique(dataset.press, return_counts=True)
    full = presses[counts == np.bincount(counts).argmax()]  # the straight one was drawn at every azimuth
    rows = [np.flatnonzero(dataset.press == press) for press in full]
    rows = [each[np.argsort(dataset.poses[each, 2])] for each in rows]
    images = np.stack([dataset.images_px[each].reshape(-1, 2) for each in rows])
    return images, np.stack([dataset.poses[each[0], :2] for each in rows]), full


def judge(reading: Reading, presses, skin, seed: int) -> list[float]:
    """RMSE and greatest error (degrees) of the best of three trainings on what is held out, and how much that is."""
    layout = place_markers(skin, MarkerSpec(count=169))
    spec = DatasetSpec(poses=reading.poses, dropped_images=reading.dropped, seed=seed)
    dataset = generate_dataset(presses, layout, build_camera(), spec)
    images, angles, press = gather(dataset, reading.whole)
    units = press if reading.split == "press" or reading.whole else np.arange(len(images))
    rng = generator(seed, "protocol", reading.name)
    chosen = rng.permutation(np.unique(units))
    held = np.isin(units, chosen[: round(0.2 * len(chosen))])
    size = np.array(dataset.image_size_px)

    def scaled(pixels):
        return ((pixels - size / 2.0) / (size / 2.0)).reshape(len(pixels), -1)

    copies = COPIES if reading.jitter in ("disc", "shift") else 1
    kept = np.repeat(images[~held], copies, axis=0)
    if reading.jitter in ("once", "disc", "shift"):
        kept = kept + draw(reading.jitter, kept.shape, rng)
    tested = images[held]
    if reading.judged == "jittered":
        tested = tested + draw(reading.jitter, tested.shape, rng)
    fresh = 2.0 if reading.jitter == "fresh" else 0.0
    columns = images.shape[1] * 2
    inputs = np.concatenate([scaled(kept), scaled(tested)])
    train = np.arange(len(inputs)) < len(kept)
    targets = np.concatenate([np.repeat(angles[~held], copies, axis=0), angles[held]])
    samples = TrainingSet(inputs, targets, train, ~train, seed)
    jitter = np.tile(fresh / (size / 2.0), images.shape[1])
    spec = paper_training(reading.layers, reading.width, 0.0)
    epochs = {"epochs": spec.epochs // copies, "stopping_patience": max(spec.stopping_patience // copies, 1)}
    spec = spec.model_copy(update=epochs)
    trained = train_network(samples, jitter, PrincipalComponents(np.zeros(columns), np.eye(columns)), spec)
    found = []
    for outputs in evaluate_perceptrons(scaled(tested), *collect_layers(trained), spec.activation):
        errors = outputs * samples.scale[1] + samples.scale[0] - angles[held]
        found.append((float(np.sqrt((errors**2).mean())), float(np.abs(errors).max()), int(held.sum())))
    return min(found)


def main(argv: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", type=Path)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--only", default="", help="readings whose name holds this")
    given = parser.parse_args(argv)
    columns = ["reading", "seed", "rmse_deg", "max_deg", "held_images"]
    if not given.table.exists():
        given.table.write_text(",".join(columns) + "\n", encoding="utf-8")
    solved = {}
    for seed in range(given.seeds):
        for reading in READINGS:
            with given.table.open(newline="", encoding="utf-8") as file:
                there = {(row["reading"], row["seed"]) for row in csv.DictReader(file)}
            if (reading.name, str(seed)) in there or given.only not in reading.name:
                continue
            if reading.contact not in solved:
                solved[reading.contact] = solve(reading.contact)
            skin, presses = solved[reading.contact]
            rmse, most, count = judge(reading, presses, skin, seed)
            with given.table.open("a", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerow(
                    [reading.name, seed, f"{rmse:.3f}", f"{most:.3f}", count]
                )
            print(f"{reading.name}, seed {seed}: {rmse:.3f}°, at most {most:.3f}°, {count} held out", flush=True)


if __name__ == "__main__":
    main()
