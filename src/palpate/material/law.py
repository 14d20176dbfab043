"""Hyperelastic laws: what a material's strain energy is, in numbers a compiled kernel understands.

Every law is isotropic and split into an isochoric part, a function of ``F_bar = J**(-1/3) F``, and the
volumetric part of `palpate.material.Material`. Three families cover all of them:

* polynomials in the invariants ``I1 = tr(b_bar)`` and ``I2 = (I1² - tr(b_bar²)) / 2``, here;
* Ogden's functions of the principal stretches, here;
* chains that lock at a finite stretch, functions of I1 alone, in `palpate.material.locking`.

References: Holzapfel, *Nonlinear Solid Mechanics* (2000), sections 6.4-6.6; Yeoh, *Rubber Chem. Technol.* 66
(1993) 754; Ogden, *Proc. R. Soc. A* 326 (1972) 565.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

POLYNOMIAL, OGDEN, GENT, ARRUDA_BOYCE = 0, 1, 2, 3
"""Codes of the laws in the compiled kernels."""


class Law(ABC):
    """Isochoric strain energy of an isotropic hyperelastic material.

    What an implementer gives: its name, its family's code and parameters for the kernels, and its shear modulus.
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """Name as on the command line, e.g. ``yeoh``."""

    @property
    @abstractmethod
    def code(self) -> int:
        """Code in the compiled kernels: `POLYNOMIAL`, `OGDEN`, `GENT` or `ARRUDA_BOYCE`."""

    @property
    @abstractmethod
    def parameters(self) -> FloatArray:
        """Parameters (k,) MPa (exponents: pure numbers) in the order that the kernel of the family reads."""

    @property
    @abstractmethod
    def shear_modulus(self) -> float:
        """Initial shear modulus, MPa."""

    @property
    @abstractmethod
    def constants(self) -> dict[str, float]:
        """Constants by the names of the literature, MPa."""


_ORDER = ("C10", "C01", "C20", "C11", "C02", "C30")


@dataclass(frozen=True)
class Polynomial(Law):
    """Polynomial in the invariants: ``W = sum C_ij (I1 - 3)^i (I2 - 3)^j``.

    Neo-Hooke is C10 alone, Mooney–Rivlin C10 and C01 (and C20, C11, C02), Yeoh C10, C20 and C30.

    Attributes
    ----------
    label
        Name on the command line.
    c10, c01, c20, c11, c02, c30
        Coefficients, MPa.
    """

    label: str
    c10: float
    c01: float = 0.0
    c20: float = 0.0
    c11: float = 0.0
    c02: float = 0.0
    c30: float = 0.0

    @property
    def name(self) -> str:
        return self.label

    @property
    def code(self) -> int:
        return POLYNOMIAL

    @property
    def parameters(self) -> FloatArray:
        return np.array([self.c10, self.c01, self.c20, self.c11, self.c02, self.c30])

    @property
    def shear_modulus(self) -> float:
        return 2 * (self.c10 + self.c01)

    @property
    def constants(self) -> dict[str, float]:
        return {name: float(value) for name, value in zip(_ORDER, self.parameters, strict=True) if value != 0}


@dataclass(frozen=True)
class Ogden(Law):
    """Ogden: ``W = sum_k mu_k / alpha_k (l1^alpha_k + l2^alpha_k + l3^alpha_k - 3)`` in isochoric stretches.

    Attributes
    ----------
    mu
        Moduli, MPa.
    alpha
        Exponents.
    """

    mu: tuple[float, ...]
    alpha: tuple[float, ...]

    @property
    def name(self) -> str:
        return "ogden"

    @property
    def code(self) -> int:
        return OGDEN

    @property
    def parameters(self) -> FloatArray:
        return np.array([*self.mu, *self.alpha])

    @property
    def shear_modulus(self) -> float:
        return float(np.dot(self.mu, self.alpha)) / 2

    @property
    def constants(self) -> dict[str, float]:
        pairs = enumerate(zip(self.mu, self.alpha, strict=True), start=1)
        return {name: value for k, (mu, alpha) in pairs for name, value in ((f"mu{k}", mu), (f"alpha{k}", alpha))}


MOONEY_RIVLIN: dict[int, tuple[str, ...]] = {
    2: ("c10", "c01"),
    3: ("c10", "c01", "c11"),
    5: ("c10", "c01", "c20", "c11", "c02"),
}
"""Coefficients of the Mooney–Rivlin laws by their count."""


def yeoh(c10: float, c20: float, c30: float) -> Polynomial:
    """Yeoh's law ``W = C10 (I1-3) + C20 (I1-3)² + C30 (I1-3)³``, coefficients in MPa."""
    return Polynomial("yeoh", c10=c10, c20=c20, c30=c30)


def neo_hooke(c10: float) -> Polynomial:
    """Neo-Hooke ``W = C10 (I1-3)``, C10 in MPa; the shear modulus is 2 C10."""
    return Polynomial("neo-hooke", c10=c10)


def mooney_rivlin(*constants: float) -> Polynomial:
    """Mooney–Rivlin, coefficients in MPa.

    Parameters
    ----------
    *constants
        C10, C01: ``W = C10 (I1-3) + C01 (I2-3)``; with a third, C11, ``+ C11 (I1-3)(I2-3)``; or the five C10, C01,
        C20, C11, C02 of the second order, ``+ C20 (I1-3)² + C11 (I1-3)(I2-3) + C02 (I2-3)²``.
    """
    return Polynomial("mooney-rivlin", **dict(zip(MOONEY_RIVLIN[len(constants)], constants, strict=True)))


def ogden(*constants: float) -> Ogden:
    """Ogden from ``mu1, alpha1, mu2, alpha2, …`` (MPa, pure number), one to three terms."""
    return Ogden(mu=tuple(constants[0::2]), alpha=tuple(constants[1::2]))
