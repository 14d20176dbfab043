"""Ogden's law, a function of the principal stretches.

In principal axes with ``e_a = ln l_a`` (Simo & Taylor, *Comput. Methods Appl. Mech. Eng.* 85 (1991) 273)

    tau_a = sum_k mu_k (l_a^alpha_k - 1/3 sum_b l_b^alpha_k)
    c     = sum_ab (d tau_a/d e_b - 2 tau_a delta_ab) m_a ⊗ m_b + shear terms between unequal axes.

Reference: Ogden, *Proc. R. Soc. A* 326 (1972) 565.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import ClassVar, final

import numpy as np

from palpate.core import FloatArray, PalpateError, kernel
from palpate.material.law import DeckLine, Law, Model, refuse_stiffening
from palpate.material.laws.invariants import answers, left_cauchy_green

_EQUAL = 1e-6
"""Relative distance below which two principal stretches count as equal."""


@final
@dataclass(frozen=True)
class Ogden(Law):
    """Ogden: ``W = sum_k mu_k / alpha_k (l1^alpha_k + l2^alpha_k + l3^alpha_k - 3)``, isochoric.

    Attributes
    ----------
    mu1, mu2, mu3
        Moduli, MPa; `None` for a missing term.
    alpha1, alpha2, alpha3
        Exponents, not zero.
    """

    name: ClassVar[str] = "ogden"
    forms: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("mu1", "alpha1"),
        ("mu1", "alpha1", "mu2", "alpha2"),
        ("mu1", "alpha1", "mu2", "alpha2", "mu3", "alpha3"),
    )

    mu1: float
    alpha1: float
    mu2: float | None = None
    alpha2: float | None = None
    mu3: float | None = None
    alpha3: float | None = None

    def __post_init__(self) -> None:
        pairs = (self.mu1, self.alpha1), (self.mu2, self.alpha2), (self.mu3, self.alpha3)
        if any((mu is None) != (alpha is None) for mu, alpha in pairs) or (self.mu2 is None and self.mu3 is not None):
            raise PalpateError(
                "A term of Ogden's law has a modulus or an exponent only.",
                "Give both, mu2 and alpha2.",
                code="law-term-incomplete",
            )
        if any(alpha == 0 for _, alpha in pairs):
            raise PalpateError(
                "An exponent alpha of Ogden's law is 0.",
                "Leave the term out: it has no stress.",
                code="law-exponent-zero",
            )

    @property
    def terms(self) -> tuple[tuple[float, float], ...]:
        """Pairs of modulus (MPa) and exponent."""
        pairs = (self.mu1, self.alpha1), (self.mu2, self.alpha2), (self.mu3, self.alpha3)
        return tuple((mu, alpha) for mu, alpha in pairs if mu is not None and alpha is not None)

    @property
    def shear_modulus(self) -> float:
        return float(np.dot([mu for mu, _ in self.terms], [alpha for _, alpha in self.terms])) / 2

    def isochoric(self, F: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        energy, tau, c = answers(len(F))
        _evaluate(np.array(self.terms).T.ravel(), F, energy, tau, c)
        return energy, tau, c

    def scaled(self, modulus: float, stiffening: float = 1.0) -> Ogden:
        refuse_stiffening(self, stiffening)
        moduli = {f"mu{k}": mu * modulus for k, (mu, _) in enumerate(self.terms, start=1)}
        return replace(self, **moduli)

    def deck(self) -> DeckLine:
        """Return the deck form ``W = sum 2 mu_k / alpha_k² (…)``, hence ``mu_deck = mu alpha / 2``."""
        pairs = tuple(value for mu, alpha in self.terms for value in (mu * alpha / 2, alpha))
        return DeckLine(f"OGDEN, N={len(self.terms)}", pairs, len(self.terms))

    @classmethod
    def models(cls) -> Sequence[Model]:
        return tuple(OgdenModel(count) for count in (1, 2, 3))


@final
@dataclass(frozen=True)
class OgdenModel(Model):
    """Ogden's law of one to three terms: linear in its moduli."""

    count: int

    @property
    def name(self) -> str:
        return f"ogden-{self.count}"

    @property
    def linear(self) -> tuple[str, ...]:
        return tuple(f"mu{k + 1}" for k in range(self.count))

    @property
    def shapes(self) -> tuple[str, ...]:
        return tuple(f"alpha{k + 1}" for k in range(self.count))

    def law(self, linear: FloatArray, shapes: FloatArray) -> Law:
        return Ogden(*(float(value) for pair in zip(linear, shapes, strict=True) for value in pair))

    def terms(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        first, third = principal[:, :1], principal[:, 2:]
        return np.asarray((first**shapes - third**shapes) / first)

    def term_slopes(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        first, third = principal[:, :1], principal[:, 2:]
        return np.asarray((first**shapes * np.log(first) - third**shapes * np.log(third)) / first)

    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        """One box for each choice of signs, and in each a start from small exponents to large ones.

        Planar tension does not distinguish a term from that with both constants negated. The positive exponent is
        taken: at the same I1 it gives far less stress in the remaining modes.
        """
        ladders = (1.3, 2.0, 4.0, 8.0, 0.4 * largest_exponent)
        found = []
        planar = np.allclose(principal[:, 1], 1.0)
        for negative in range(1 if planar else self.count + 1):
            sign = np.where(np.arange(self.count) < self.count - negative, 1.0, -1.0)
            box = np.sort(np.stack([0.05 * sign, largest_exponent * sign]), axis=0)
            for steps in product(range(len(ladders)), repeat=self.count):
                if sum(steps) <= 2 * self.count and _grow_within_signs(steps, sign):
                    rungs = np.array([ladders[step] for step in steps])
                    found.append((box, np.minimum(rungs, largest_exponent) * sign))
        return found

    def signs(self, shapes: FloatArray) -> FloatArray:
        """Each term by itself is stable if ``mu alpha >= 0``."""
        return np.sign(shapes)


def _grow_within_signs(steps: tuple[int, ...], sign: FloatArray) -> bool:
    """Whether exponents of one sign grow: every set of them is then written once."""
    pairs = zip(range(len(steps) - 1), range(1, len(steps)), strict=True)
    return all(sign[a] != sign[b] or steps[a] < steps[b] for a, b in pairs)


@kernel
def _evaluate(parameters: FloatArray, F: FloatArray, energy: FloatArray, tau: FloatArray, c: FloatArray) -> None:
    for i in range(len(F)):
        energy[i] = _ogden(parameters, F[i], tau[i], c[i])


@kernel
def _ogden(parameters: FloatArray, F: FloatArray, tau: FloatArray, c: FloatArray) -> float:
    terms = len(parameters) // 2
    b = np.empty(6)
    left_cauchy_green(F, b)
    matrix = np.empty((3, 3))
    matrix[0, 0], matrix[1, 1], matrix[2, 2] = b[0], b[1], b[2]
    matrix[0, 1] = matrix[1, 0] = b[3]
    matrix[1, 2] = matrix[2, 1] = b[4]
    matrix[0, 2] = matrix[2, 0] = b[5]
    square, axis = np.linalg.eigh(matrix)
    beta = np.zeros(3)
    slope = np.zeros((3, 3))
    energy = 0.0
    for k in range(terms):
        mu, alpha = parameters[k], parameters[terms + k]
        power = square ** (0.5 * alpha)
        total = power[0] + power[1] + power[2]
        energy += mu / alpha * (total - 3.0)
        for a in range(3):
            beta[a] += mu * (power[a] - total / 3.0)
            for d in range(3):
                slope[a, d] += mu * alpha * (total / 9.0 - (power[a] + power[d]) / 3.0)
            slope[a, a] += mu * alpha * power[a]
    tau[:] = 0.0
    c[:, :] = 0.0
    m = np.empty(6)
    n = np.empty(6)
    for a in range(3):
        _dyad(axis, a, a, m)
        for p in range(6):
            tau[p] += beta[a] * m[p]
        for d in range(3):
            _dyad(axis, d, d, n)
            factor = slope[a, d] - (2.0 * beta[a] if a == d else 0.0)
            for p in range(6):
                for q in range(6):
                    c[p, q] += factor * m[p] * n[q]
        for d in range(a):
            _dyad(axis, a, d, m)
            gap = square[a] - square[d]
            if abs(gap) > _EQUAL * (square[a] + square[d]):
                factor = (beta[a] * square[d] - beta[d] * square[a]) / gap
            else:
                mean = 0.25 * (slope[a, a] - slope[a, d] + slope[d, d] - slope[d, a])
                factor = mean - 0.5 * (beta[a] + beta[d])
            for p in range(6):
                for q in range(6):
                    c[p, q] += 4.0 * factor * m[p] * m[q]
    return energy


@kernel
def _dyad(axis: FloatArray, a: int, d: int, m: FloatArray) -> None:
    """Write the symmetric dyad of two principal axes (columns of `axis`)."""
    m[0] = axis[0, a] * axis[0, d]
    m[1] = axis[1, a] * axis[1, d]
    m[2] = axis[2, a] * axis[2, d]
    m[3] = 0.5 * (axis[0, a] * axis[1, d] + axis[1, a] * axis[0, d])
    m[4] = 0.5 * (axis[1, a] * axis[2, d] + axis[2, a] * axis[1, d])
    m[5] = 0.5 * (axis[2, a] * axis[0, d] + axis[0, a] * axis[2, d])
