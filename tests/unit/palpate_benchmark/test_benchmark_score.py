"""The judge of predictions: its figures against numpy's, controls, and what it refuses."""

import csv
import time
from pathlib import Path

import numpy as np
import pytest
from palpate_benchmark import (
    PRESETS,
    BenchmarkSet,
    Predictions,
    read_predictions,
    read_set,
    score_file,
    score_predictions,
    write_predictions,
)

from errors import refused
from palpate.core import FloatArray

IMAGES, PICTURED = 400, 60
LABELS = ("rx_deg", "ry_deg", "depth_mm", "force_n", "shear_n", "friction")


@pytest.fixture(scope="module")
def labels() -> FloatArray:
    rng = np.random.default_rng(1)
    return np.column_stack(
        [
            rng.uniform(-12, 12, (IMAGES, 2)),
            rng.uniform(1, 8, IMAGES),
            rng.uniform(0, 1, IMAGES),
            rng.uniform(0, 0.5, IMAGES),
            rng.uniform(0.3, 3, IMAGES),
        ]
    )


@pytest.fixture(scope="module")
def numbers() -> np.ndarray:
    return np.sort(np.random.default_rng(2).permutation(5 * IMAGES)[:IMAGES])


@pytest.fixture(scope="module")
def made_set(tmp_path_factory: pytest.TempPathFactory, labels: FloatArray, numbers: np.ndarray) -> BenchmarkSet:
    """The tables of a test of two designs of four units each."""
    folder = tmp_path_factory.mktemp("set")
    (folder / "spec.json").write_text(PRESETS["tiny"].model_dump_json())
    (folder / "SHA256SUMS").write_text("")
    with (folder / "test.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(("image", "design", "unit", "picture"))
        for k, number in enumerate(numbers):
            rows.writerow((number, "AB"[k % 2], 17 + k // 2 % 4, f"test/{number}.png" if k < PICTURED else ""))
    with (folder / "hidden.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(("image", "press", *LABELS, "branch"))
        for k, number in enumerate(numbers):
            rows.writerow((number, k // 10, *labels[k].tolist(), "inverted" if k % 5 == 0 else "flat"))
    return read_set(folder)


def told(numbers: np.ndarray, labels: FloatArray, off: float = 0.0) -> Predictions:
    rng = np.random.default_rng(3)
    names = ("rx_deg", "ry_deg", "depth_mm", "force_n")
    return Predictions(
        numbers, {name: labels[:, k] + off * rng.standard_normal(len(labels)) for k, name in enumerate(names)}
    )


def test_the_truth_has_no_error(made_set: BenchmarkSet, numbers: np.ndarray, labels: FloatArray) -> None:
    found = score_predictions(made_set, told(numbers, labels))
    for line in found.lines:
        for part in line.parts.values():
            assert (part.rmse, part.max, part.p95) == (0.0, 0.0, 0.0)


def test_figures_are_those_of_a_plain_calculation(
    made_set: BenchmarkSet, numbers: np.ndarray, labels: FloatArray, tmp_path: Path
) -> None:
    predictions = told(numbers, labels, 0.3)
    halves = {f"half_{name}": np.full(IMAGES, 0.4) for name in predictions.values}
    shuffled = np.random.default_rng(4).permutation(IMAGES)
    table = Predictions(
        numbers[shuffled], {key: value[shuffled] for key, value in (predictions.values | halves).items()}
    )
    write_predictions(tmp_path / "p.csv", table)
    found = score_file(made_set, tmp_path / "p.csv")
    rx, ry = (np.round(predictions.values[name], 6) - labels[:, k] for k, name in enumerate(("rx_deg", "ry_deg")))
    for line in found.lines:
        if line.by == "unit":
            design, unit = line.name.split()
            rows = [k for k in range(IMAGES) if "AB"[k % 2] == design and 17 + k // 2 % 4 == int(unit)]
        elif line.by == "friction":
            low, high = (float(word) for word in line.name.split(" to "))
            rows = [k for k in range(IMAGES) if low < labels[k, 5] <= high]
        elif line.by == "depth_mm":
            low = float(line.name.split(" to ")[0])
            rows = [k for k in range(IMAGES) if int(labels[k, 2]) == int(low)]
        elif line.by == "branch":
            rows = [k for k in range(IMAGES) if (k % 5 == 0) == (line.name == "inverted")]
        else:
            rows = [k for k in range(IMAGES) if line.name in ("all", "AB"[k % 2])]
        errors = sorted(abs(e) for k in rows for e in (rx[k], ry[k]))
        part = line.parts["angle"]
        assert line.images == len(rows) > 0
        assert part.rmse == pytest.approx((sum(e * e for e in errors) / len(errors)) ** 0.5, rel=1e-9)
        assert part.max == pytest.approx(errors[-1], rel=1e-9)
        assert sum(e <= part.p95 for e in errors) >= 0.95 * len(errors)
        assert sum(e < part.p95 for e in errors) < 0.95 * len(errors)
        assert part.coverage == pytest.approx(sum(e <= 0.4 for e in errors) / len(errors), rel=1e-9)
        assert part.half_width == pytest.approx(0.4)
    groups = {line.by: 0 for line in found.lines}
    for line in found.lines:
        groups[line.by] += line.images
    assert set(groups.values()) == {IMAGES}
    worst = max(line.parts["angle"].p95 for line in found.lines if line.by == "unit")
    assert found.worst_unit_p95_deg == worst


def test_predictions_of_other_rows_are_judged_as_bad_as_chance(
    made_set: BenchmarkSet, numbers: np.ndarray, labels: FloatArray
) -> None:
    rng = np.random.default_rng(5)
    found = score_predictions(made_set, told(numbers, labels[rng.permutation(IMAGES)]))
    chance = np.sqrt(2.0) * labels[:, :2].std()
    assert found.all.parts["angle"].rmse == pytest.approx(chance, rel=0.1)


def test_the_track_of_pictures_has_its_own_images(
    made_set: BenchmarkSet, numbers: np.ndarray, labels: FloatArray
) -> None:
    found = score_predictions(made_set, told(numbers[:PICTURED], labels[:PICTURED]), "pictures")
    assert found.all.images == PICTURED
    with refused("predictions-missing", "340", "400"):
        score_predictions(made_set, told(numbers[:PICTURED], labels[:PICTURED]))
    with refused("prediction-image-unknown", "340", "pictures"):
        score_predictions(made_set, told(numbers, labels), "pictures")


def test_a_hundred_thousand_rows_are_read_within_seconds(tmp_path: Path) -> None:
    count = 100_000
    table = Predictions(
        np.arange(count), {name: np.linspace(0, 1, count) for name in ("rx_deg", "ry_deg", "depth_mm")}
    )
    write_predictions(tmp_path / "p.csv", table)
    start = time.process_time()
    found = read_predictions(tmp_path / "p.csv")
    assert time.process_time() - start < 10.0
    assert np.abs(found.values["ry_deg"] - table.values["ry_deg"]).max() < 1e-6


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("image,rx_deg,ry_deg\n1,0,0\n", ("column-missing", "depth_mm")),
        ("image,rx_deg,ry_deg,depth_mm,colour\n1,0,0,0,0\n", ("column-unknown", "colour")),
        ("image,rx_deg,ry_deg,depth_mm,rx_deg\n1,0,0,0,0\n", ("column-twice",)),
        ("image,rx_deg,ry_deg,depth_mm\n", ("table-empty",)),
        ("image,rx_deg,ry_deg,depth_mm\n1,0,nan,0\n", ("value-not-number", "nan", "ry_deg", "2")),
        ("image,rx_deg,ry_deg,depth_mm\n1,0,0,0\n2,0,,0\n", ("value-not-number", "ry_deg", "3")),
        ("image,rx_deg,ry_deg,depth_mm\n1,0,inf,0\n", ("value-not-number", "inf")),
        ("image,rx_deg,ry_deg,depth_mm\n1.5,0,0,0\n", ("prediction-not-image", "1.5")),
        ("image,rx_deg,ry_deg,depth_mm\n1,0,0\n", ("value-not-number", "2", "depth_mm")),
        ("image,rx_deg,ry_deg,depth_mm,half_rx_deg\n1,0,0,0,-1\n", ("half-width-negative", "half_rx_deg", "-1")),
    ],
)
def test_a_table_that_cannot_be_judged_is_refused_with_its_line(
    tmp_path: Path, text: str, says: tuple[str, ...]
) -> None:
    (tmp_path / "p.csv").write_text(text)
    with refused(*says):
        read_predictions(tmp_path / "p.csv")


def test_images_twice_missing_or_unknown_are_refused(
    made_set: BenchmarkSet, numbers: np.ndarray, labels: FloatArray
) -> None:
    right = told(numbers, labels)
    for change, says in (
        (np.append(np.arange(IMAGES - 1), 0), ("prediction-twice", "1")),
        (np.arange(IMAGES - 3), ("predictions-missing", "3", "400")),
    ):
        rows = Predictions(right.image[change], {name: value[change] for name, value in right.values.items()})
        with refused(*says):
            score_predictions(made_set, rows)
    strange = Predictions(np.append(numbers[:-1], 10**6), right.values)
    with refused("prediction-image-unknown", "1000000"):
        score_predictions(made_set, strange)
