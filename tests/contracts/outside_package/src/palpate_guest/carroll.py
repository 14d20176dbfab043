"""Carroll's law for rubber, by numpy alone.

Reference: Carroll, *J. Elast.* 103 (2011) 173.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError
from palpate.material import Law, LinearModel, Model

Array = NDArray[np.float64]
_FIRST, _SECOND = [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]
_UNIT = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True)
class Carroll(Law):
    """``W = a (I1 - 3) + b (I1⁴ - 81) + c (sqrt(I2) - sqrt(3))``, constants in MPa."""

    name: ClassVar[str] = "carroll"

    a: float
    b: float
    c: float

    @property
    def shear_modulus(self) -> float:
        return 2 * (self.a + 108 * self.b + self.c / np.sqrt(12))

    def isochoric(self, F: Array) -> tuple[Array, Array, Array]:
        J = np.linalg.det(F)
        b = J[:, None, None] ** (-2 / 3) * F @ np.swapaxes(F, 1, 2)
        square = b @ b
        I1 = np.trace(b, axis1=1, axis2=2)
        I2 = 0.5 * (I1**2 - np.trace(square, axis1=1, axis2=2))
        energy = self.a * (I1 - 3) + self.b * (I1**4 - 81) + self.c * (np.sqrt(I2) - np.sqrt(3))
        W1, W11 = self.a + 4 * self.b * I1**3, 12 * self.b * I1**2
        W2, W22 = 0.5 * self.c / np.sqrt(I2), -0.25 * self.c / I2**1.5
        one, two = _voigt(b), _voigt(square)
        tau = 2 * (W1 + I1 * W2)[:, None] * one - 2 * W2[:, None] * two
        cross = np.einsum("ni,nj->nij", one, two)
        c = (
            _times(4 * (W11 + W2 + I1**2 * W22), np.einsum("ni,nj->nij", one, one))
            - _times(4 * I1 * W22, cross + np.swapaxes(cross, 1, 2))
            + _times(4 * W22, np.einsum("ni,nj->nij", two, two))
            - _times(4 * W2, _symmetric_square(b))
        )
        trace = tau[:, :3].sum(axis=1)
        P = np.diag([1, 1, 1, 0.5, 0.5, 0.5]) - np.outer(_UNIT, _UNIT) / 3
        project = np.eye(6) - np.outer(_UNIT, _UNIT) / 3
        tau = tau @ project
        side = np.einsum("i,nj->nij", _UNIT, tau)
        c = project @ c @ project + _times(2 / 3 * trace, P) - 2 / 3 * (side + np.swapaxes(side, 1, 2))
        return energy, tau, c

    def scaled(self, modulus: float, stiffening: float = 1.0) -> Carroll:
        if stiffening != 1.0:
            raise PalpateError(
                "Carroll's law stiffens by no single constant.", "Set the tolerance to 0.", code="law-not-stiffening"
            )
        return replace(self, a=self.a * modulus, b=self.b * modulus, c=self.c * modulus)

    def deck(self) -> None:
        return None

    @classmethod
    def models(cls) -> Sequence[Model]:
        return (LinearModel("carroll", cls, ("a", "b", "c")),)


def _voigt(tensor: Array) -> Array:
    return tensor[:, _FIRST, _SECOND]


def _times(factor: Array, tensor: Array) -> Array:
    return factor[:, None, None] * tensor


def _symmetric_square(b: Array) -> Array:
    """``(b_ik b_jl + b_il b_jk) / 2`` in Voigt order."""
    full = np.einsum("nik,njl->nijkl", b, b)
    full = 0.5 * (full + np.einsum("nil,njk->nijkl", b, b))
    return full[:, _FIRST, _SECOND][:, :, _FIRST, _SECOND]
