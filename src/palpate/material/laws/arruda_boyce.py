"""Arruda and Boyce's law: eight chains that lock at their full length.

The inverse Langevin function is replaced by the first five terms of its series, as in Abaqus and CalculiX.

Reference: Arruda & Boyce, *J. Mech. Phys. Solids* 41 (1993) 389.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from palpate.core import FloatArray, PalpateError, kernel
from palpate.material.law import DeckLine, Law, Model, refuse_stiffening
from palpate.material.laws.invariants import answers, first_invariant, left_cauchy_green, stretched
from palpate.material.model import ChainModel

_CHAIN = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
"""Factors of the series."""


@final
@dataclass(frozen=True)
class ArrudaBoyce(Law):
    """Arruda–Boyce: ``W = mu sum_i C_i lm^(2 - 2 i) (I1^i - 3^i)`` with five terms.

    Attributes
    ----------
    mu
        Modulus, MPa; the initial shear modulus is ``2 mu sum_i i C_i (3 / lm²)^(i - 1)``, a little more.
    lm
        Stretch at which a chain locks.
    """

    name: ClassVar[str] = "arruda-boyce"

    mu: float
    lm: float

    def __post_init__(self) -> None:
        if not 0 < self.lm < np.inf:
            raise PalpateError(
                f"Arruda–Boyce's lm is {self.lm:g}.",
                "It is the stretch of a straight chain: give a positive number.",
                code="law-constant-not-positive",
            )

    @property
    def shear_modulus(self) -> float:
        terms = ((i + 1) * factor * (3 / self.lm**2) ** i for i, factor in enumerate(_CHAIN))
        return 2 * self.mu * sum(terms)

    def isochoric(self, F: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        energy, tau, c = answers(len(F))
        _evaluate(self.mu, self.lm, F, energy, tau, c)
        return energy, tau, c

    def scaled(self, modulus: float, stiffening: float = 1.0) -> ArrudaBoyce:
        refuse_stiffening(self, stiffening)
        return replace(self, mu=self.mu * modulus)

    def deck(self) -> DeckLine:
        """Return the same series with the same factor mu, not Abaqus' initial shear modulus mu_0.

        The volumetric part of Abaqus is ``((J² - 1) / 2 - ln J) / D`` for this law only: with ``D = 2 / K`` it agrees
        with palpate's to the third order in ``J - 1``.
        """
        return DeckLine("ARRUDA-BOYCE", (self.mu, self.lm))

    @classmethod
    def models(cls) -> Sequence[Model]:
        return (ArrudaBoyceModel(),)


@final
class ArrudaBoyceModel(ChainModel):
    """Linear in the modulus; the shape is lm."""

    form: ClassVar[type[Law]] = ArrudaBoyce

    def slope(self, principal: FloatArray, shape: float) -> tuple[FloatArray, FloatArray]:
        order = np.arange(1, len(_CHAIN) + 1)
        each = (
            np.array(_CHAIN) * order * (stretched(principal)[:, None] + 3) ** (order - 1) * shape ** (2.0 - 2 * order)
        )
        return each.sum(axis=1), np.asarray((each * (2 - 2 * order)).sum(axis=1) / shape)

    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        chain = np.sqrt(stretched(principal).max() / 3 + 1)
        box = np.array([[0.2], [1e3]])
        return [(box, np.array([chain * factor])) for factor in (0.6, 1.0, 2.0, 6.0)]


@kernel
def _evaluate(mu: float, lm: float, F: FloatArray, energy: FloatArray, tau: FloatArray, c: FloatArray) -> None:
    b = np.empty(6)
    for i in range(len(F)):
        left_cauchy_green(F[i], b)
        I1 = b[0] + b[1] + b[2]
        slack = 1.0 / (lm * lm)
        scale, power = mu, 1.0
        total, W1, W11 = 0.0, 0.0, 0.0
        for k in range(len(_CHAIN)):
            order = k + 1.0
            total += scale * _CHAIN[k] * (power * I1 - 3.0**order)
            W1 += scale * _CHAIN[k] * order * power
            W11 += scale * _CHAIN[k] * order * (order - 1.0) * power / I1
            scale *= slack
            power *= I1
        energy[i] = total
        first_invariant(W1, W11, b, tau[i], c[i])
