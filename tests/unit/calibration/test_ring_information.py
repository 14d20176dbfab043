"""Information of rings against the accuracy that is predicted without it, and against itself in other ways."""

from dataclasses import replace

import numpy as np
import pytest

from palpate.calibration import (
    AccuracySpec,
    RingInformation,
    ToleranceSpec,
    compute_ring_information,
    predict_accuracy,
)
from palpate.calibration.groups import sum_by_group
from palpate.camera import CameraSpec, build_camera
from palpate.design import MarkerLayout, place_markers
from palpate.surrogate import Twin
from small_chain import MARKERS, small_twin

TOLERANCE = ToleranceSpec()
CAMERA = build_camera()


def accuracy_spec(presses: int, noise_px: float = 0.02) -> AccuracySpec:
    return AccuracySpec(poses=10, units=50, noise_px=noise_px, calibration_presses=presses)


@pytest.fixture(scope="module")
def twin() -> Twin:
    return small_twin()


@pytest.fixture(scope="module")
def layout(twin: Twin) -> MarkerLayout:
    return place_markers(twin.skin, MARKERS)


def rings(layout: MarkerLayout) -> np.ndarray:
    return np.unique(np.hypot(*layout.positions[:, :2].T).round(3), return_inverse=True)[1]


def compute(twin: Twin, layout: MarkerLayout, presses: int, noise_px: float = 0.02) -> RingInformation:
    return compute_ring_information(twin, layout, rings(layout), CAMERA, TOLERANCE, accuracy_spec(presses, noise_px))


@pytest.mark.parametrize("noise_px", [0.02, 0.1])
@pytest.mark.parametrize("presses", [0, 2])
def test_all_rings_have_the_variance_of_the_predicted_accuracy(
    twin: Twin, layout: MarkerLayout, presses: int, noise_px: float
) -> None:
    info = compute(twin, layout, presses, noise_px)
    whole = predict_accuracy(twin, layout, CAMERA, TOLERANCE, accuracy_spec(presses, noise_px))
    assert info.variance(np.ones(len(info.rest))) == pytest.approx(whole.rmse_deg**2, rel=0.02)
    assert info.inside.all()


@pytest.mark.parametrize("presses", [0, 2])
def test_other_noise_gives_the_information_computed_with_it(twin: Twin, layout: MarkerLayout, presses: int) -> None:
    info, other = compute(twin, layout, presses), compute(twin, layout, presses, 0.05)
    again = info.with_noise(other.noise_px)
    assert again.reads == pytest.approx(other.reads, rel=1e-6)
    share = np.linspace(0.3, 1.0, len(info.rest))
    assert again.variance(share) == pytest.approx(other.variance(share), rel=0.05)
    assert info.variance(share) < again.variance(share)
    assert again.with_noise(info.noise_px).variance(share) == pytest.approx(info.variance(share), rel=1e-6)


@pytest.mark.parametrize("presses", [0, 2])
def test_the_lower_bound_is_below_the_variance_convex_and_falls_with_every_ring(
    twin: Twin, layout: MarkerLayout, presses: int
) -> None:
    info = compute(twin, layout, presses)
    bound, rng = info.lower_bound(), np.random.default_rng(1)
    for _ in range(4):
        one, other = rng.uniform(0.2, 1.0, (2, len(info.rest)))
        low, high = bound.variance(one), info.variance(one)
        assert 0.3 * high < low < high
        assert bound.variance((one + other) / 2) <= (low + bound.variance(other)) / 2 * (1 + 1e-9)
        more = one.copy()
        more[rng.integers(len(one))] = 1.0
        assert bound.variance(more) <= low * (1 + 1e-9)


def bound_by_normal_equations(info: RingInformation, share: np.ndarray) -> float:
    """Variance of rx or ry by the priors and all markers, whose only error is noise in rest image and press."""
    own = info.noise_px**2
    weight = share * (2 * own + info.model_px**2) / (2 * own)
    camera = np.linalg.inv(np.diag(info.rest_prior) + np.einsum("g,gij->ij", share, info.rest))[:10, :10]
    free = np.isfinite(info.touch_prior)
    prior = np.diag(np.concatenate([info.touch_prior[free], np.zeros(10), info.unit_sd[-1:] ** -2]))
    prior[-11:-1, -11:-1] = np.linalg.inv(camera)
    keep = np.concatenate([free, np.ones(11, bool)])
    total = 0.0
    for read, by_mounting in zip(info.reads, info.by_mounting, strict=True):
        normal = np.einsum("g,gij->ij", weight, read)[np.ix_(keep, keep)] + prior
        total += np.trace(np.linalg.inv(normal)[:2, :2]) + np.sum(by_mounting[:2] ** 2 @ info.mounting_sd**2)
    return float(total / (2 * len(info.reads)))


def test_the_bound_without_presses_is_that_of_the_normal_equations(twin: Twin, layout: MarkerLayout) -> None:
    """But for the error of the twin, which no share of the rings changes."""
    info = compute(twin, layout, 0)
    shares = [np.linspace(0.4, 1.0, len(info.rest)), np.linspace(0.9, 0.1, len(info.rest))]
    one, other = (info.lower_bound().variance(share) - bound_by_normal_equations(info, share) for share in shares)
    assert one == pytest.approx(other, rel=1e-3)
    assert 0 < one < 0.1 * info.variance(shares[0])


def test_rings_of_larger_markers_are_seen_with_their_noise(twin: Twin, layout: MarkerLayout) -> None:
    info = compute(twin, layout, 0)
    large = replace(layout, diameter=2.0 * layout.diameter)
    resized = info.with_markers(twin.skin, large, rings(layout), CAMERA, 0.02)
    assert resized.noise_px != pytest.approx(info.noise_px)
    assert resized.variance(np.ones(len(info.rest))) == pytest.approx(
        info.with_noise(resized.noise_px).variance(np.ones(len(info.rest)))
    )


def test_rings_that_leave_the_image_are_told(twin: Twin, layout: MarkerLayout) -> None:
    near = build_camera(CameraSpec(fx_px=500.0, fy_px=500.0))
    group = rings(layout)
    info = compute_ring_information(twin, layout, group, near, TOLERANCE, accuracy_spec(0))
    assert info.inside[0]
    assert not info.inside.all()
    pixels = near.project(layout.positions)
    out = ((pixels < 5) | (pixels > [near.width_px - 6, near.height_px - 6])).any(axis=1)
    assert not info.inside[np.unique(group[out])].any()


def test_groups_add_up_to_the_whole(twin: Twin, layout: MarkerLayout) -> None:
    info = compute(twin, layout, 2)
    one = compute_ring_information(twin, layout, np.zeros(len(layout), int), CAMERA, TOLERANCE, accuracy_spec(2))
    assert info.rest.sum(axis=0) == pytest.approx(one.rest[0], abs=1e-6)
    assert info.reads.sum(axis=1) == pytest.approx(one.reads[:, 0], abs=1e-6)
    assert info.variance(np.ones(len(info.rest))) == pytest.approx(one.variance(np.ones(1)), rel=1e-6)
    left = np.random.default_rng(2).normal(size=(len(layout), 2, 3))
    assert sum_by_group(left, left, rings(layout)).sum(axis=0) == pytest.approx(np.einsum("mci,mcj->ij", left, left))
