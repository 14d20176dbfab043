"""Gent's law: chains that lock at their full length.

Reference: Gent, *Rubber Chem. Technol.* 69 (1996) 59.
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


@final
@dataclass(frozen=True)
class Gent(Law):
    """Gent: ``W = -mu Jm / 2 ln(1 - (I1 - 3) / Jm)``; the chains lock at ``I1 = 3 + Jm``.

    Attributes
    ----------
    mu
        Initial shear modulus, MPa.
    Jm
        Maximum of ``I1 - 3``.
    """

    name: ClassVar[str] = "gent"

    mu: float
    Jm: float

    def __post_init__(self) -> None:
        if not 0 < self.Jm < np.inf:
            raise PalpateError(
                f"Gent's Jm is {self.Jm:g}.",
                "It is the maximum of I1 - 3: give a positive number.",
                code="law-constant-not-positive",
            )

    @property
    def shear_modulus(self) -> float:
        return self.mu

    def isochoric(self, F: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        energy, tau, c = answers(len(F))
        _evaluate(self.mu, self.Jm, F, energy, tau, c)
        return energy, tau, c

    def scaled(self, modulus: float, stiffening: float = 1.0) -> Gent:
        refuse_stiffening(self, stiffening)
        return replace(self, mu=self.mu * modulus)

    def deck(self) -> DeckLine | None:
        return None

    @classmethod
    def models(cls) -> Sequence[Model]:
        return (GentModel(),)


@final
class GentModel(ChainModel):
    """Linear in the modulus; the shape is Jm."""

    form: ClassVar[type[Law]] = Gent

    def slope(self, principal: FloatArray, shape: float) -> tuple[FloatArray, FloatArray]:
        x = stretched(principal)
        left = 1 - x / shape
        return 0.5 / left, -0.5 * x / (left * shape) ** 2

    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        greatest = stretched(principal).max()
        box = np.array([[greatest * (1 + 1e-6)], [1e5 * greatest + 1]])
        return [(box, np.array([greatest * factor])) for factor in (1.02, 1.3, 3.0, 20.0)]


@kernel
def _evaluate(mu: float, Jm: float, F: FloatArray, energy: FloatArray, tau: FloatArray, c: FloatArray) -> None:
    b = np.empty(6)
    for i in range(len(F)):
        left_cauchy_green(F[i], b)
        I1 = b[0] + b[1] + b[2]
        left = 1.0 - (I1 - 3.0) / Jm
        W1, W11 = 0.0, 0.0
        energy[i] = np.inf
        if left > 0.0:
            energy[i] = -0.5 * mu * Jm * np.log(left)
            W1 = 0.5 * mu / left
            W11 = W1 / (left * Jm)
        first_invariant(W1, W11, b, tau[i], c[i])
