"""The order of a file's rows does not matter, unless a specimen was unloaded: then it says which branch is which."""

import re
from pathlib import Path

import numpy as np
import pytest

from palpate.cli import main
from palpate.material import FitSpec, Loading, PrepareSpec, Sample, fit_material, prepare_sample, read_test_file

SEEDS = range(25)


def hand_drawn(loading: Loading, rows: int, noise: float = 0.0, seed: int = 0) -> Sample:
    """A curve by a formula that is no law of ours, an arctangent that stiffens; noise over its greatest stress."""
    rng = np.random.default_rng(seed)
    end = 0.55 if loading is Loading.COMPRESSION else 2.6
    stretch = 1 + (end - 1) * np.sort(rng.uniform(0.01, 1, rows))
    strain = stretch - 1
    stress = 0.04 * np.arctan(2 * strain) + 0.01 * strain**3
    return Sample("drawn", loading, stretch, stress + noise * np.abs(stress).max() * rng.normal(size=rows))


def ordered(sample: Sample, order: np.ndarray) -> Sample:
    return Sample(sample.name, sample.loading, sample.stretch[order], sample.nominal[order], sample.notes)


def cycle(loading: Loading, rows: int, loss: float, noise: float, seed: int = 0) -> tuple[Sample, int]:
    """Loading and unloading in the order of time, the way back lower by a loss; and the rows of the way there."""
    up = hand_drawn(loading, rows, noise, seed)
    up = ordered(up, np.argsort(np.abs(up.stretch - 1)))
    back = hand_drawn(loading, rows, noise, seed + 1000)
    back = ordered(back, np.argsort(-np.abs(back.stretch - 1)))
    back = back.where(np.abs(back.stretch - 1) < np.abs(up.stretch[-1] - 1))
    stretch, nominal = np.append(up.stretch, back.stretch), np.append(up.nominal, (1 - loss) * back.nominal)
    return Sample("cycle", loading, stretch, nominal), rows


@pytest.mark.parametrize("loading", [Loading.TENSION, Loading.COMPRESSION])
@pytest.mark.parametrize("rows", [6, 12, 60, 400])
@pytest.mark.parametrize("noise", [0.0, 0.01, 0.03])
def test_a_file_in_any_order_is_the_sorted_file(loading: Loading, rows: int, noise: float) -> None:
    spec = PrepareSpec()
    for seed in SEEDS:
        sample = hand_drawn(loading, rows, noise, seed)
        outward = ordered(sample, np.argsort(np.abs(sample.stretch - 1)))
        expected = prepare_sample(outward, spec)
        rng = np.random.default_rng(seed)
        half = rows // 2
        for order in (
            np.arange(rows)[::-1],
            rng.permutation(rows),
            np.roll(np.arange(rows), half),
            np.append(np.arange(rows)[::2], np.arange(rows)[1::2]),
        ):
            found = prepare_sample(ordered(outward, order), spec)
            assert found.stretch == pytest.approx(expected.stretch, rel=1e-12), (seed, order)
            assert found.nominal == pytest.approx(expected.nominal, rel=1e-12)
            assert found.notes == expected.notes


@pytest.mark.parametrize("loading", [Loading.TENSION, Loading.COMPRESSION])
@pytest.mark.parametrize(("rows", "loss", "noise"), [(20, 0.25, 0.005), (30, 0.1, 0.005), (300, 0.1, 0.01)])
def test_of_a_cycle_only_the_way_there_is_kept(loading: Loading, rows: int, loss: float, noise: float) -> None:
    kept = 0
    for seed in SEEDS:
        whole, up = cycle(loading, rows, loss, noise, seed)
        found = prepare_sample(whole, PrepareSpec(points=None))
        kept += len(found.stretch) == up and np.all(np.isin(found.nominal, whole.nominal[:up]))
    assert kept >= 24


def test_a_cycle_is_kept_whole_where_that_is_asked_for() -> None:
    whole, _ = cycle(Loading.TENSION, 40, 0.2, 0.0)
    found = prepare_sample(whole, PrepareSpec(points=None, until_break=False))
    assert np.array_equal(found.stretch, whole.stretch)


def test_a_specimen_that_springs_back_when_it_breaks_is_cut_at_the_break() -> None:
    whole = hand_drawn(Loading.TENSION, 200, 0.005)
    back = whole.stretch[-1] - np.array([0.003, 0.01, 0.3, 0.9])
    broken = Sample(
        "broken", Loading.TENSION, np.append(whole.stretch, back), np.append(whole.nominal, [0.02, 1e-4, 0, 0])
    )
    found = prepare_sample(broken, PrepareSpec(points=None))
    assert len(found.stretch) >= 199
    assert found.nominal.min() >= whole.nominal.min()


def test_a_stretch_that_trembles_is_one_sweep() -> None:
    whole = hand_drawn(Loading.TENSION, 500, 0.005)
    rng = np.random.default_rng(3)
    moved = Sample("trembles", Loading.TENSION, whole.stretch + 0.004 * rng.normal(size=500), whole.nominal)
    assert len(prepare_sample(moved, PrepareSpec(points=None)).stretch) > 490


@pytest.mark.parametrize("name", ["compression", "tension"])
def test_the_fit_of_a_shuffled_file_is_that_of_the_sorted_one(name: str, tmp_path: Path) -> None:
    sample = hand_drawn(Loading(name), 150, 0.01)
    fits = []
    for order in (np.arange(150), np.arange(150)[::-1], np.random.default_rng(5).permutation(150)):
        path = tmp_path / f"{name}.csv"
        rows = [f"{a:.9g},{b:.9g}" for a, b in zip(sample.stretch[order], sample.nominal[order], strict=True)]
        path.write_text("\n".join(["stretch,stress (MPa)", *rows]))
        (read,) = read_test_file(path)
        fits.append(fit_material([prepare_sample(read, PrepareSpec())], FitSpec(model="yeoh")).linear)
    assert fits[1] == pytest.approx(fits[0], rel=1e-9)
    assert fits[2] == pytest.approx(fits[0], rel=1e-9)


def test_the_command_reads_a_compression_file_whose_stretches_rise(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stretch = np.linspace(0.55, 1, 40)
    path = tmp_path / "compression.csv"
    rows = [f"{a:.6f},{b:.6f}" for a, b in zip(stretch, 0.05 * (stretch - stretch**-2), strict=True)]
    path.write_text("\n".join(["stretch,stress (MPa)", *rows]))
    with pytest.raises(SystemExit) as left:
        main(["material", "fit", str(path), "--model", "neo-hooke", "--alone"])
    assert left.value.code in (0, None)
    shown = capsys.readouterr().out
    assert re.search(r"^compression.csv +compression +40 +0.55 to 1 +137.8 *$", shown, re.MULTILINE)  # no remark
    assert re.search(r"^C10 +0.02(5|49999)", shown, re.MULTILINE)
