"""Rings, their model, warps and false alarms against a pinhole camera, ellipses, binomials and polynomials."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.spatial import cKDTree

from palpate.vision.fit_free_pattern import fit_warp
from palpate.vision.fit_ring import ALONE, DOT_PX, INSIDE, NEXT, RingFitter, prior_rows
from palpate.vision.ring_model import BENT, TWIST, Profile, RingFit, RingsFit, extrapolate_ring, fit_ring_model
from palpate.vision.rings import find_rings, ring_harmonics

SPHERE, FOCAL, DISTANCE = 20.0, 300.0, 60.0
RHO = np.array([2.0, 5.0, 8.0, 11.0])


def scale_at(rho: np.ndarray | float, centre: float = -3.0) -> np.ndarray:
    """Pixels per mm of a pinhole that looks at a sphere from a distance."""
    return FOCAL / (DISTANCE - centre - np.sqrt(SPHERE**2 - np.square(rho)))


def profile(centre: float = -3.0) -> Profile:
    return Profile(RHO, centre + np.sqrt(SPHERE**2 - RHO**2), RHO * scale_at(RHO, centre))


@pytest.mark.parametrize("centre", [-8.0, 0.0, 5.0])
def test_a_profile_has_scale_slope_and_radius_of_the_pinhole_between_and_beyond_its_rings(centre: float) -> None:
    law = profile(centre)
    for rho in (0.0, 3.0, 9.5, 13.0):
        assert float(law.scale(rho)) == pytest.approx(float(scale_at(rho, centre)), rel=1e-9)
        h = 1e-4
        slope = ((rho + h) * scale_at(rho + h, centre) - (rho - h) * scale_at(rho - h, centre)) / (2 * h)
        assert law.slope(rho) == pytest.approx(slope, rel=1e-4)
        assert float(law.rho(rho * scale_at(rho, centre))) == pytest.approx(rho, abs=1e-3)


def test_a_flat_profile_has_one_scale_and_ends_by_a_share_beyond_its_rings() -> None:
    flat = Profile(RHO, np.full(4, 7.0), 5.0 * RHO)
    assert flat.scale(RHO + 1.0) == pytest.approx(np.full(4, 5.0))
    assert flat.widest == pytest.approx(1.3 * RHO[-1])
    assert profile().widest > RHO[-1]


def test_rings_that_deviate_from_the_sphere_are_interpolated() -> None:
    law = Profile(RHO, -3 + np.sqrt(SPHERE**2 - RHO**2), RHO * scale_at(RHO) * [1.0, 1.02, 0.99, 1.01])
    assert law.scale(RHO) * RHO == pytest.approx(RHO * scale_at(RHO) * [1.0, 1.02, 0.99, 1.01])


def ring(radius: float, turn: float = 0.0, centre: tuple[float, float] = (0.0, 0.0), count: int = 12) -> RingFit:
    weights = np.zeros((7, 2))
    weights[0] = centre
    weights[1], weights[2] = (
        radius * np.array([np.cos(turn), np.sin(turn)]),
        radius * np.array([-np.sin(turn), np.cos(turn)]),
    )
    return RingFit(weights, np.arange(count), np.full(count, 0.1), -5.0)


def test_a_ring_has_count_share_residual_turn_and_radius() -> None:
    whole = ring(30.0, 0.4)
    assert (whole.turn, whole.radius_px) == pytest.approx((0.4, 30.0))
    part = replace(
        whole,
        blob=np.where(np.arange(12) < 3, -1, np.arange(12)),
        error_px=np.array([np.nan] * 3 + [0.3] * 8 + [0.6]),
    )
    assert (part.count, part.share) == (9, 0.75)
    assert part.residual_px == pytest.approx(np.sqrt((8 * 0.09 + 0.36) / 9))
    assert np.isinf(replace(whole, error_px=np.full(12, np.nan)).residual_px)
    limit = 0.07 * 2 * np.pi * 30 / 12
    assert replace(whole, error_px=np.full(12, 0.999 * limit)).even
    assert not replace(whole, error_px=np.full(12, 1.001 * limit)).even
    ellipse = replace(whole, weights=ring(30.0, 0.0).weights @ np.diag([1.5, 0.5]))
    assert (ellipse.turn, ellipse.radius_px) == pytest.approx((0.0, 30.0))


def stack(*rings: RingFit) -> RingsFit:
    return RingsFit((ring(0.0, count=1), *rings))


def test_rings_are_even_if_none_is_turned_or_crosses_another() -> None:
    good = stack(ring(10.0, 0.1, count=6), ring(20.0, 0.1), ring(30.0, 0.1, count=18))
    assert good.even
    assert good.count == 1 + 6 + 12 + 18
    assert good.residual_px == pytest.approx(0.1)
    assert good.power == pytest.approx(-20.0)
    step = 2 * np.pi / 12
    for share in (0.99 * TWIST, 1.01 * TWIST, -1.01 * TWIST):
        bent = stack(ring(10.0, 0.1, count=6), ring(20.0, 0.1 + share * step))
        assert bent.twist == pytest.approx([share])
        assert bent.even == (abs(share) < TWIST)
        assert bent.power == pytest.approx(-15.0 + 20.0 * share**2)
    assert stack(ring(10.0, 3.1, count=6), ring(20.0, -3.1)).twist == pytest.approx([(2 * np.pi - 6.2) / step])
    for aside, crossing in ((6.99, 0), (7.01, 3)):
        found = stack(ring(10.0, count=6), ring(20.0, count=12), ring(30.0, 0.0, (0.0, aside), count=18))
        assert found.crossing == crossing
        assert found.even == (crossing == 0)
    assert np.isinf(stack(replace(ring(9.0), error_px=np.full(12, np.nan))).residual_px)


def seen_rings(zoom: float, offset_mm: np.ndarray, centre: np.ndarray) -> list[RingFit]:
    """Rings of the sphere by a camera `zoom` times as near, which stands aside by an offset."""
    return [
        ring(zoom * rho * g, 0.0, tuple(centre + zoom * g * offset_mm))
        for rho, g in zip(RHO, scale_at(RHO), strict=True)
    ]


def test_centres_of_rings_tell_how_far_aside_the_camera_stands() -> None:
    offset, centre = np.array([1.5, -0.8]), np.array([170.0, 120.0])
    rings = seen_rings(1.0, offset, centre)
    model = fit_ring_model(rings, profile(), RHO * scale_at(RHO), RHO)
    assert model.zoom == pytest.approx(1.0)
    assert model.rho == pytest.approx(RHO, abs=2e-3)
    assert model.drift[1] == pytest.approx(offset, abs=0.15)
    for rho, each in zip(RHO, rings, strict=True):
        assert model.centre(float(rho)) == pytest.approx(each.weights[0], abs=0.1)
    assert model.left_px == pytest.approx(np.zeros((4, 2)), abs=0.1)
    assert model.radius_px(rings[1].radius_px, RHO[2] / RHO[1], 1.0) == pytest.approx(rings[2].radius_px, rel=1e-3)
    assert model.radius_px(rings[1].radius_px, 100.0, 1.0) == pytest.approx(
        model.profile.widest * float(model.profile.scale(model.profile.widest)), rel=1e-6
    )
    slopes = [profile().slope(float(rho)) for rho in RHO[[1, 3]]]
    assert model.steeper(rings[1].radius_px, rings[3].radius_px) == pytest.approx(
        abs(slopes[1] - slopes[0]), rel=1e-2
    )


def test_a_fifth_of_a_common_growth_is_the_cameras() -> None:
    model = fit_ring_model(seen_rings(1.1, np.zeros(2), np.zeros(2)), profile(), RHO * scale_at(RHO), RHO)
    assert model.zoom == pytest.approx(1.02)
    assert model.rho * model.profile.scale(model.rho) * 1.02 == pytest.approx(1.1 * RHO * scale_at(RHO), rel=1e-3)


def test_the_scatter_of_centres_lies_between_the_expected_and_the_seen() -> None:
    model = fit_ring_model(seen_rings(1.0, np.zeros(2), np.zeros(2)), profile(), RHO * scale_at(RHO), RHO)
    for left, expected in (((1.0, 0.0), 0.5), ((0.0, 2.0), 3.0)):
        with_left = replace(model, left_px=np.tile(left, (6, 1)))
        seen = 6 * np.dot(left, left) / 2 / 4
        assert with_left.centre_sd_px(expected) ** 2 == pytest.approx((4 * seen + 2 * expected**2) / 6)
    assert replace(model, left_px=np.zeros((1, 2))).centre_sd_px(0.7) == pytest.approx(0.7)


def test_a_ring_beyond_is_where_the_camera_shows_it() -> None:
    offset, centre = np.array([0.6, -0.4]), np.array([170.0, 120.0])
    rings = seen_rings(1.0, offset, centre)
    model = fit_ring_model(rings[:3], profile(), RHO * scale_at(RHO), RHO)
    weights, zoom_sd, aside = extrapolate_ring(model, rings[2], (RHO[2], RHO[3]))
    assert RingFit(weights, np.arange(3), np.zeros(3)).radius_px == pytest.approx(rings[3].radius_px, rel=2e-3)
    assert weights[0] == pytest.approx(rings[3].weights[0], abs=0.15)
    shares = [model.radius_px(rings[2].radius_px, RHO[3] / RHO[2], share) for share in (0.965, 1.0, 1.035)]
    assert zoom_sd == pytest.approx(max(abs(shares[0] - shares[1]), abs(shares[2] - shares[1])))
    grown = abs(float(model.profile.scale(RHO[3]) - model.profile.scale(RHO[2])))
    assert aside == pytest.approx(model.drift_sd * grown, rel=5e-3)
    few = fit_ring_model(rings[:2], profile(), RHO * scale_at(RHO), RHO)
    assert few.drift_sd > model.drift_sd
    assert few.drift_sd < 4.0
    bent = fit_ring_model(rings[:3], profile(), RHO * scale_at(RHO), RHO * (1 + 2 * BENT))
    assert bent.drift_sd > model.drift_sd


def layout(*counts: int, centre: bool = True) -> np.ndarray:
    rows = [[0.0, 0.0, 20.0]] if centre else []
    for number, count in enumerate(counts, start=1):
        azimuth = 0.3 * number + 2 * np.pi * np.arange(count) / count
        rows += [[3.0 * number * np.cos(a), 3.0 * number * np.sin(a), 20.0 - number] for a in azimuth]
    return np.array(rows)


def test_rings_of_a_layout_are_found_from_the_inside() -> None:
    places = layout(4, 8)
    order = np.random.default_rng(1).permutation(len(places))
    rings = find_rings(places[order])
    assert rings is not None
    assert len(rings) == 2
    assert rings.number.tolist() == [0 if k == 0 else 1 if k < 5 else 2 for k in order]
    assert rings.rho == pytest.approx([0, 3, 6])
    assert rings.height == pytest.approx([20, 19, 18])
    assert rings.azimuth[rings.members(1)] == pytest.approx(
        (np.arctan2(*places[order][rings.members(1), 1::-1].T)) % (2 * np.pi)
    )
    hollow = find_rings(layout(4, 8, centre=False))
    assert hollow is not None
    assert (hollow.rho.tolist()[0], np.isnan(hollow.height[0]), sorted(set(hollow.number))) == (0.0, True, [1, 2])


@pytest.mark.parametrize("fault", ["three", "uneven", "two centres", "nan", "one place", "few"])
def test_a_layout_that_is_no_rings_has_none(fault: str) -> None:
    places = layout(4, 8)
    if fault == "three":
        places = layout(3, 8)
    if fault == "uneven":
        turn = 0.01
        places[6, :2] = places[6, :2] @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    if fault == "two centres":
        places = np.vstack([places, [[0.0, 0.0, 20.0]]])
    if fault == "nan":
        places[3, 1] = np.nan
    if fault == "one place":
        places = np.zeros((5, 3))
    if fault == "few":
        places = places[:1]
    assert find_rings(places) is None


@pytest.mark.parametrize("terms", [3, 6, 10])
def test_a_warp_gives_a_polynomial_of_its_order_exactly_and_by_the_normal_equations_its_spread(terms: int) -> None:
    rng = np.random.default_rng(6)
    order = {3: 1, 6: 2, 10: 3}[terms]
    whole, places = rng.uniform(-40, 60, (60, 2)), rng.uniform(-40, 60, (7, 2))

    def map_of(points: np.ndarray) -> np.ndarray:
        x, y = points.T / 30
        rows = [x**a * y**b for a in range(order + 1) for b in range(order + 1 - a)]
        return 5 * np.stack(rows, -1) @ np.random.default_rng(order).normal(size=(len(rows), 2))

    warp = fit_warp(whole[:40], map_of(whole[:40]), terms, whole)
    assert warp(places) == pytest.approx(map_of(places), rel=1e-6, abs=1e-6)
    noisy = map_of(whole[:40]) + rng.normal(0, 0.3, (40, 2))
    warp = fit_warp(whole[:40], noisy, terms, whole)
    rows = np.stack(
        [whole[:40, 0] ** a * whole[:40, 1] ** b for a in range(order + 1) for b in range(order + 1 - a)], -1
    )
    fit = np.linalg.lstsq(rows, noisy, rcond=None)[0]
    left = np.median(np.abs(noisy - rows @ fit)) / stats.norm.ppf(0.75) * np.sqrt(40 / (40 - terms))
    assert warp.spread_px == pytest.approx(left, rel=1e-3)
    at = np.stack([places[:, 0] ** a * places[:, 1] ** b for a in range(order + 1) for b in range(order + 1 - a)], -1)
    leverage = np.einsum("ni,ij,nj->n", at, np.linalg.inv(rows.T @ rows), at)
    assert warp.deviation_px(places) == pytest.approx(warp.spread_px * np.sqrt(1 + leverage), rel=1e-4)
    assert np.isfinite(fit_warp(whole[: terms + 6], noisy[: terms + 6], terms, whole).spread_px)
    assert np.isinf(fit_warp(whole[: terms + 5], noisy[: terms + 5], terms, whole).spread_px)


BLOBS = np.random.default_rng(3).uniform(0, 200, (50, 2))


def test_the_number_of_false_alarms_counts_the_ways_and_chances_of_a_ring() -> None:
    fitter = RingFitter(BLOBS)
    area = np.prod(np.ptp(BLOBS, axis=0))
    assert fitter.density == pytest.approx(50 / area)
    left = np.array([0.5, 0.1, np.nan, 1.2, 0.9, np.nan])
    blob = np.where(np.isfinite(left), 1, -1)
    best = 0.0
    for kept, far in enumerate(sorted(left[blob >= 0]), start=1):
        chance = 50 / area * np.pi * max(far, 0.25) ** 2
        ways = 1 / stats.hypergeom.pmf(kept, 6, kept, kept)
        best = min(best, np.log10(ways) + max(kept - 1.5, 0) * np.log10(chance))
    assert fitter.power(blob, left, 1.5) == pytest.approx(best)
    assert fitter.power(blob, left, 4.0) == 0.0
    assert fitter.power(np.full(6, -1), np.full(6, np.nan), 1.5) == 0.0


def test_each_blob_is_taken_once_and_only_if_free_and_near() -> None:
    fitter, taken = RingFitter(BLOBS), np.zeros(50, bool)
    places = np.vstack([BLOBS[4] + [0.3, 0.0], BLOBS[4] - [0.1, 0.0], BLOBS[7] + [0.0, 0.5], BLOBS[9] + [0.0, 2.0]])
    apart = cKDTree(BLOBS).query(places)
    assert apart[1].tolist() == [4, 4, 7, 9]
    blob, off = fitter.nearest(places, 1.0, taken)
    assert blob.tolist() == [-1, 4, 7, -1]
    assert off == pytest.approx([np.nan, 0.1, 0.5, np.nan], nan_ok=True)
    taken[7] = True
    assert fitter.nearest(places, 3.0, taken)[0].tolist() == [-1, 4, -1, 9]


@pytest.mark.parametrize("prior", [ALONE, NEXT, INSIDE])
def test_a_prior_holds_centre_and_harmonics_by_their_deviations(prior) -> None:
    weights = ring(40.0, 0.7, (3.0, 4.0)).weights
    rows, right = prior_rows(weights, prior)
    sd = [prior.centre_px, *(40.0 * each for each in prior.harmonics for _ in "xy")]
    assert np.diag(rows) == pytest.approx(DOT_PX / np.array(sd))
    assert np.linalg.solve(rows, right) == pytest.approx(weights)
    assert not (rows - np.diag(np.diag(rows))).any()


def test_a_ring_is_fitted_to_its_blobs_and_a_false_one_is_left_out() -> None:
    phi = 2 * np.pi * np.arange(18) / 18
    true = ring(60.0, 0.2, (100.0, 90.0)).weights
    true[3] = [0.4, -0.3]
    places = ring_harmonics(phi, 7) @ true
    blobs = np.vstack([places, [[20.0, 20.0], [180.0, 170.0], [30.0, 160.0]]])
    blobs[5] += [4.0, 1.0]
    order = np.random.default_rng(5).permutation(len(blobs))
    start = ring(60.5, 0.19, (100.5, 89.5)).weights
    found = RingFitter(blobs[order]).fit(start, np.zeros(len(blobs), bool), phi, NEXT)
    truth = np.argsort(order)[:18]
    assert found.blob.tolist() == [-1 if k == 5 else int(truth[k]) for k in range(18)]
    assert ring_harmonics(phi, 7) @ found.weights == pytest.approx(places, abs=0.15)
    assert found.power < -15
    scanned = RingFitter(blobs[order]).scan(
        ring(40.0, 0.2, (100.0, 90.0)), phi, np.linspace(1.2, 1.8, 25), np.zeros((1, 2)), np.zeros(len(blobs), bool)
    )
    assert scanned.radius_px == pytest.approx(60.0, abs=0.2)
