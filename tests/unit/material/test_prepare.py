"""Preparing curves: the break, the toe, trimming, thinning and the mean of samples."""

from dataclasses import replace

import numpy as np
import pytest

from errors import check_values, refused
from palpate.material import Loading, PrepareSpec, Sample, get_material, prepare_sample, trace_curve
from palpate.material.prepare import average_samples, toe_offset

RAW = PrepareSpec(points=None)


def curve(loading: Loading = Loading.TENSION, end: float = 3.0, rows: int = 200) -> Sample:
    stretch = np.linspace(1, end, rows)
    nominal = trace_curve(get_material("zaid_2024_ecoflex_00_30"), loading.mode, stretch).nominal
    return Sample(str(loading), loading, stretch, nominal)


def test_rows_after_the_break_are_left_out() -> None:
    whole = curve()
    broken = replace(
        whole,
        stretch=np.append(whole.stretch, [3.01, 3.02, 3.03]),
        nominal=np.append(whole.nominal, [0.5 * whole.nominal[-1], 0.001, 0.0]),
    )
    ready = prepare_sample(broken, RAW)
    assert np.array_equal(ready.stretch, whole.stretch)
    check_values(ready.notes[0], 3, "break")
    assert len(prepare_sample(broken, PrepareSpec(points=None, until_break=False)).stretch) == 203


def test_rows_of_unloading_are_left_out() -> None:
    whole = curve(Loading.COMPRESSION, 0.5)
    cycle = replace(
        whole,
        stretch=np.append(whole.stretch, whole.stretch[::-1]),
        nominal=np.append(whole.nominal, 0.9 * whole.nominal[::-1]),
    )
    assert np.array_equal(prepare_sample(cycle, RAW).nominal, whole.nominal)


def test_a_small_drop_is_no_break() -> None:
    whole = curve()
    dip = whole.nominal.copy()
    dip[100] *= 0.9
    assert len(prepare_sample(replace(whole, nominal=dip), RAW).stretch) == 200


@pytest.mark.parametrize("loading", [Loading.TENSION, Loading.COMPRESSION])
def test_a_toe_is_compensated(loading: Loading) -> None:
    """The grips close for 0.03 of strain, with a soft start, before the specimen takes up the load."""
    whole = curve(loading, 2.0 if loading is Loading.TENSION else 0.6, 400)
    sign = 1 if loading is Loading.TENSION else -1
    grip = np.linspace(0, 0.03, 12, endpoint=False)
    slack = replace(
        whole,
        stretch=np.concatenate([1 + sign * grip, whole.stretch + sign * 0.03]),
        nominal=np.concatenate([0 * grip, whole.nominal]),
    )
    assert toe_offset(slack) == pytest.approx(sign * 0.03, abs=0.003)
    ready = prepare_sample(slack, PrepareSpec(points=None, toe="auto"))
    far = ready.stretch[-1]
    assert far == pytest.approx(whole.stretch[-1], abs=0.003)
    check_values(ready.notes[0], "toe")


def test_a_curve_without_a_toe_is_left_alone() -> None:
    whole = curve()
    assert abs(toe_offset(whole)) < 1e-3


def test_rows_outside_the_range_are_left_out() -> None:
    ready = prepare_sample(curve(), PrepareSpec(points=None, min_stretch=0.5, max_stretch=2))
    assert ready.stretch.max() <= 2
    with refused("samples-few-rows-left"):
        prepare_sample(curve(), PrepareSpec(max_stretch=1.01))


def test_the_strain_of_the_crosshead_is_corrected() -> None:
    ready = prepare_sample(curve(), PrepareSpec(points=None, strain_factor=0.56))
    assert ready.stretch[-1] == pytest.approx(1 + 0.56 * 2)


def test_a_long_sample_is_averaged_to_even_rows_and_keeps_its_course() -> None:
    rng = np.random.default_rng(0)
    long = curve(rows=20_000)
    noisy = replace(long, nominal=long.nominal + 2e-4 * rng.normal(size=20_000))
    ready = prepare_sample(noisy, PrepareSpec(points=100, until_break=False))
    assert len(ready.stretch) == 100
    expected = np.interp(ready.stretch, long.stretch, long.nominal)
    assert ready.nominal == pytest.approx(expected, abs=1e-4)
    assert len(prepare_sample(curve(rows=60), PrepareSpec(points=100)).stretch) == 60


def test_the_mean_of_samples_and_their_spread() -> None:
    samples = [
        replace(curve(end=end), nominal=factor * curve(end=end).nominal) for end, factor in ((3.0, 0.9), (2.5, 1.1))
    ]
    mean = average_samples(samples)
    assert mean.stretch[-1] == pytest.approx(2.5)
    middle = np.interp(mean.stretch, curve().stretch, curve().nominal)
    assert mean.mean == pytest.approx(middle, abs=1e-5)
    assert mean.spread == pytest.approx(np.sqrt(0.02) * middle, abs=1e-5)
    assert mean.count == 2
    assert np.isnan(average_samples(samples[:1]).spread).all()


def test_samples_without_a_common_stretch_have_no_mean() -> None:
    with refused("samples-no-common-stretch"):
        average_samples([curve(), curve(Loading.COMPRESSION, 0.5)])
