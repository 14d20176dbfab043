"""Polynomials in the invariants, ``W = sum C_ij (I1 - 3)^i (I2 - 3)^j``.

Reference: Rivlin & Saunders, *Phil. Trans. R. Soc. A* 243 (1951) 251.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import ClassVar, Self, final

import numpy as np

from palpate.core import FloatArray, kernel
from palpate.material.law import DeckLine, Law, Model
from palpate.material.laws.invariants import add_projector, answers, left_cauchy_green, project

_ORDER = ("C10", "C01", "C20", "C11", "C02", "C30")
_FIRST = ("C10", "C01")


@dataclass(frozen=True)
class PolynomialLaw(Law):
    """A law whose fields are some of C10, C01, C20, C11, C02 and C30, MPa."""

    @property
    def coefficients(self) -> FloatArray:
        """C10, C01, C20, C11, C02, C30 (6,) MPa."""
        return np.array([getattr(self, name, 0.0) for name in _ORDER], float)

    @property
    def shear_modulus(self) -> float:
        return float(2 * self.coefficients[:2].sum())

    def isochoric(self, F: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        energy, tau, c = answers(len(F))
        _evaluate(self.coefficients, F, energy, tau, c)
        return energy, tau, c

    def scaled(self, modulus: float, stiffening: float = 1.0) -> Self:
        values = {item.name: getattr(self, item.name) * modulus for item in fields(self)}
        return replace(self, **{n: v if n in _FIRST else v * stiffening for n, v in values.items()})

    def deck(self) -> DeckLine:
        c10, c01, c20, c11, c02, c30 = self.coefficients.tolist()
        only_first = c01 == c11 == c02 == 0
        if only_first and c20 == c30 == 0:
            return DeckLine("NEO HOOKE", (c10,))
        if only_first:
            return DeckLine("YEOH", (c10, c20, c30), 3)
        if c20 == c11 == c02 == c30 == 0:
            return DeckLine("MOONEY-RIVLIN", (c10, c01))
        if c30 == 0:
            return DeckLine("POLYNOMIAL, N=2", (c10, c01, c20, c11, c02), 2)
        return DeckLine("POLYNOMIAL, N=3", (c10, c01, c20, c11, c02, c30, 0.0, 0.0, 0.0), 3)


@final
@dataclass(frozen=True)
class Polynomial(PolynomialLaw):
    """The polynomial of the third order without C21 and C12, coefficients in MPa."""

    name: ClassVar[str] = "polynomial"

    C10: float = 0.0
    C01: float = 0.0
    C20: float = 0.0
    C11: float = 0.0
    C02: float = 0.0
    C30: float = 0.0

    @classmethod
    def models(cls) -> Sequence[Model]:
        return ()


@kernel
def _evaluate(parameters: FloatArray, F: FloatArray, energy: FloatArray, tau: FloatArray, c: FloatArray) -> None:
    squares = np.empty((2, 6))
    for i in range(len(F)):
        energy[i] = _polynomial(parameters, F[i], squares, tau[i], c[i])


@kernel
def _add_symmetric_square(factor: float, b: FloatArray, c: FloatArray) -> None:
    """Add ``factor`` times the push-forward of the symmetric identity, ``(b_ik b_jl + b_il b_jk) / 2``."""
    first = (0, 1, 2, 0, 1, 2)
    second = (0, 1, 2, 1, 2, 0)
    at = ((0, 3, 5), (3, 1, 4), (5, 4, 2))
    for p in range(6):
        i, j = first[p], second[p]
        for q in range(6):
            k, l = first[q], second[q]
            c[p, q] += factor * 0.5 * (b[at[i][k]] * b[at[j][l]] + b[at[i][l]] * b[at[j][k]])


@kernel
def _polynomial(parameters: FloatArray, F: FloatArray, squares: FloatArray, tau: FloatArray, c: FloatArray) -> float:
    c10, c01, c20, c11, c02, c30 = parameters
    b, b2 = squares[0], squares[1]
    left_cauchy_green(F, b)
    b2[0] = b[0] * b[0] + b[3] * b[3] + b[5] * b[5]
    b2[1] = b[3] * b[3] + b[1] * b[1] + b[4] * b[4]
    b2[2] = b[5] * b[5] + b[4] * b[4] + b[2] * b[2]
    b2[3] = b[0] * b[3] + b[3] * b[1] + b[5] * b[4]
    b2[4] = b[3] * b[5] + b[1] * b[4] + b[4] * b[2]
    b2[5] = b[5] * b[0] + b[4] * b[3] + b[2] * b[5]
    I1 = b[0] + b[1] + b[2]
    I2 = 0.5 * (I1 * I1 - b2[0] - b2[1] - b2[2])
    x, y = I1 - 3.0, I2 - 3.0
    W1 = c10 + 2.0 * c20 * x + c11 * y + 3.0 * c30 * x * x
    W2 = c01 + c11 * x + 2.0 * c02 * y
    W11 = 2.0 * c20 + 6.0 * c30 * x
    W12, W22 = c11, 2.0 * c02
    trace = 0.0
    for p in range(6):
        tau[p] = 2.0 * (W1 + I1 * W2) * b[p] - 2.0 * W2 * b2[p]
    trace = tau[0] + tau[1] + tau[2]
    bb = 4.0 * (W11 + 2.0 * I1 * W12 + W2 + I1 * I1 * W22)
    b_b2 = -4.0 * (W12 + I1 * W22)
    b2_b2 = 4.0 * W22
    for p in range(6):
        for q in range(6):
            c[p, q] = bb * b[p] * b[q] + b_b2 * (b[p] * b2[q] + b2[p] * b[q]) + b2_b2 * b2[p] * b2[q]
    if W2 != 0.0:
        _add_symmetric_square(-4.0 * W2, b, c)
    project(c)
    for p in range(3):
        tau[p] -= trace / 3.0
    add_projector(trace, tau, c)
    return c10 * x + c01 * y + c20 * x * x + c11 * x * y + c02 * y * y + c30 * x * x * x
