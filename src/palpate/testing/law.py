"""Contract suite of material laws."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from palpate.core import FloatArray, PalpateError
from palpate.material import LAWS, DeckLine, Law, Material, Mode, Model, read_material, stretches, write_material

_VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Indices of the components of a symmetric tensor."""


class LawSuite:
    """Inherit and give the fixture `law`; pytest collects the rest.

    Examples
    --------
    ::

        class TestIsihara(LawSuite):
            @pytest.fixture(params=[(0.02, 0.001, 0.0005)])
            def law(self, request):
                return Isihara(*request.param)
    """

    @pytest.fixture
    def law(self) -> Law:
        """A law with constants of a rubber; each of those with a default has another value."""
        raise NotImplementedError("Give the fixture `law`.")

    @pytest.fixture
    def states(self) -> FloatArray:
        """Deformation gradients (n, 3, 3) of the evaluation; a law that locks earlier overrides them."""
        F = np.eye(3) + 0.25 * np.random.default_rng(0).normal(size=(1500, 3, 3))
        return np.ascontiguousarray(F[np.linalg.det(F) > 0.3][:500])

    def test_it_is_found_by_its_name(self, law: Law) -> None:
        assert LAWS.get(law.name) is type(law)

    def test_it_gives_new_arrays_of_the_right_shape_and_leaves_its_input(self, law: Law, states: FloatArray) -> None:
        before = states.copy()
        first, second = law.isochoric(states), law.isochoric(states)
        n = len(states)
        assert [each.shape for each in first] == [(n,), (n, 6), (n, 6, 6)]
        assert all(np.isfinite(each).all() for each in first)
        assert np.array_equal(states, before)
        for a, b in zip(first, second, strict=True):
            assert np.array_equal(a, b)
            assert not np.shares_memory(a, b)

    def test_stress_is_the_slope_of_energy_and_the_tangent_that_of_stress(self, law: Law, states: FloatArray) -> None:
        """Central differences at two steps, extrapolated: their error is of the fourth order."""
        _, tau, c = law.isochoric(states)
        scale, stiffest = np.abs(tau).max(), np.abs(c).max(axis=(1, 2))
        for q, (k, l) in enumerate(_VOIGT):
            d = np.zeros((3, 3))
            d[k, l] += 0.5
            d[l, k] += 0.5
            slope, rate = np.zeros(len(states)), np.zeros((len(states), 6))
            for step, weight in ((2e-4, -1 / 3), (1e-4, 4 / 3)):
                ahead, behind = (law.isochoric(states + sign * step * d @ states) for sign in (1, -1))
                slope += weight * (ahead[0] - behind[0]) / (2 * step)
                rate += weight * (ahead[1] - behind[1]) / (2 * step)
            turned = _tensor(rate) - d @ _tensor(tau) - _tensor(tau) @ d
            assert np.abs(slope - tau[:, q]).max() < 1e-8 * scale
            assert (np.abs(turned - _tensor(c[:, :, q])).max(axis=(1, 2)) < 1e-7 * stiffest).all()

    def test_the_tangent_is_symmetric(self, law: Law, states: FloatArray) -> None:
        _, _, c = law.isochoric(states)
        assert np.abs(c - np.swapaxes(c, 1, 2)).max() < 1e-12 * np.abs(c).max()

    def test_the_stress_has_no_mean_and_ignores_the_volume(self, law: Law, states: FloatArray) -> None:
        energy, tau, _ = law.isochoric(states)
        assert np.abs(tau[:, :3].sum(axis=1)).max() < 1e-12 * np.abs(tau).max()
        swollen = law.isochoric(1.3 * states)
        assert swollen[0] == pytest.approx(energy, rel=1e-9, abs=1e-15)
        assert swollen[1] == pytest.approx(tau, abs=1e-10 * np.abs(tau).max())

    def test_energy_and_stress_do_not_depend_on_the_frame_or_the_grain(self, law: Law, states: FloatArray) -> None:
        Q = _rotations(len(states))
        energy, tau, c = law.isochoric(states)
        turned = law.isochoric(np.ascontiguousarray(Q @ states))
        isotropic = law.isochoric(np.ascontiguousarray(states @ Q))
        scale = np.abs(tau).max()
        assert turned[0] == pytest.approx(energy, rel=1e-9, abs=1e-14)
        assert isotropic[0] == pytest.approx(energy, rel=1e-9, abs=1e-14)
        assert _tensor(turned[1]) == pytest.approx(Q @ _tensor(tau) @ np.swapaxes(Q, 1, 2), abs=1e-10 * scale)
        assert isotropic[1] == pytest.approx(tau, abs=1e-10 * scale)
        assert isotropic[2] == pytest.approx(c, abs=1e-9 * np.abs(c).max())

    def test_rest_is_free_of_stress_and_as_stiff_as_the_shear_modulus_says(self, law: Law) -> None:
        energy, tau, c = law.isochoric(_rotations(500))
        mu = law.shear_modulus
        assert mu > 0
        assert np.abs(energy).max() < 1e-14
        assert np.abs(tau).max() < 1e-13 * max(mu, 1)
        assert c[:, 3, 3] == pytest.approx(mu)
        assert c[:, 0, 0] == pytest.approx(4 / 3 * mu)

    def test_it_survives_its_constants_and_a_file(self, law: Law, tmp_path: Path) -> None:
        assert type(law).from_constants(law.constants) == law
        assert set(law.constants) <= set(type(law).constants_text().replace(" or ", ",").split(","))
        write_material(tmp_path / "mine.yaml", Material("mine", law))
        assert read_material(tmp_path / "mine.yaml").law == law

    def test_other_constants_are_refused_with_its_own_names(self, law: Law) -> None:
        with pytest.raises(PalpateError, match=r"The constants of .* are not .*They are"):
            type(law).from_constants({"no_such_constant": 1.0})
        with pytest.raises(PalpateError, match="takes"):
            type(law).from_numbers([0.1] * 40)

    def test_twice_the_modulus_is_twice_the_stress(self, law: Law, states: FloatArray) -> None:
        once, twice = law.isochoric(states), law.scaled(2.0).isochoric(states)
        for a, b in zip(once, twice, strict=True):
            assert b == pytest.approx(2 * a, rel=1e-10, abs=1e-12 * np.abs(b).max())
        with suppress(PalpateError):  # a law without constants of higher order
            assert law.scaled(1.0, 1.1).shear_modulus == pytest.approx(law.shear_modulus)

    def test_it_has_a_line_for_a_deck_or_says_that_there_is_none(self, law: Law) -> None:
        line = law.deck()
        if line is not None:
            assert isinstance(line, DeckLine)
            assert line.parameter == line.parameter.upper()
            assert np.isfinite(line.constants).all()
            assert line.volumetric >= 1

    def test_its_fit_terms_are_its_stress(self, law: Law) -> None:
        for model in _models(law):
            linear = np.array([law.constants[name] for name in model.linear])
            shapes = np.array([law.constants[name] for name in model.shapes])
            assert model.law(linear, shapes) == law
            for mode in Mode:
                principal = stretches(mode, np.linspace(0.7, 1.8, 30))
                _, tau, _ = law.isochoric(np.ascontiguousarray(principal[:, :, None] * np.eye(3)))
                nominal = (tau[:, 0] - tau[:, 2]) / principal[:, 0]
                assert model.terms(principal, shapes) @ linear == pytest.approx(nominal, rel=1e-10, abs=1e-12)
                _compare_slopes(model, principal, shapes)


def _models(law: Law) -> list[Model]:
    """Models of the law that have just its constants."""
    return [model for model in law.models() if set(model.constants) == set(law.constants)]


def _compare_slopes(model: Model, principal: FloatArray, shapes: FloatArray) -> None:
    slopes = model.term_slopes(principal, shapes)
    assert slopes.shape == (len(principal), len(shapes))
    if len(shapes):
        step = 1e-6 * np.abs(shapes)
        ahead, behind = model.terms(principal, shapes + step), model.terms(principal, shapes - step)
        assert slopes == pytest.approx((ahead - behind) / (2 * step), rel=1e-6, abs=1e-9 * np.abs(slopes).max())
        starts = model.starts(principal, 30.0)
        assert starts
        assert all(((box[0] <= start) & (start <= box[1])).all() for box, start in starts)
        assert model.signs(shapes).shape == (len(model.linear),)


def _tensor(voigt: FloatArray) -> FloatArray:
    xx, yy, zz, xy, yz, zx = np.moveaxis(voigt, -1, 0)
    return np.stack([np.stack([xx, xy, zx], -1), np.stack([xy, yy, yz], -1), np.stack([zx, yz, zz], -1)], -2)


def _rotations(count: int) -> FloatArray:
    q, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(count, 3, 3)))
    return np.ascontiguousarray(q * np.sign(np.linalg.det(q))[:, None, None])
