"""Laws of chains that lock: the stress grows without bound, or steeply, where the chains are drawn straight.

References: Gent, *Rubber Chem. Technol.* 69 (1996) 59; Arruda & Boyce, *J. Mech. Phys. Solids* 41 (1993) 389, the
inverse Langevin function by its first five terms, as in Abaqus and CalculiX.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import PalpateError
from palpate.material.law import ARRUDA_BOYCE, GENT, FloatArray, Law

CHAIN = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
"""Factors of Arruda and Boyce's series."""


@dataclass(frozen=True)
class Gent(Law):
    """Gent: ``W = -mu Jm / 2 ln(1 - (I1 - 3) / Jm)``; the chains lock at ``I1 = 3 + Jm``.

    Attributes
    ----------
    mu
        Initial shear modulus, MPa.
    jm
        Greatest ``I1 - 3``.
    """

    mu: float
    jm: float

    def __post_init__(self) -> None:
        if not 0 < self.jm < np.inf:
            raise PalpateError(f"Gent's Jm is {self.jm:g}.", "It is the greatest I1 - 3: give a positive number.")

    @property
    def name(self) -> str:
        return "gent"

    @property
    def code(self) -> int:
        return GENT

    @property
    def parameters(self) -> FloatArray:
        return np.array([self.mu, self.jm])

    @property
    def shear_modulus(self) -> float:
        return self.mu

    @property
    def constants(self) -> dict[str, float]:
        return {"mu": self.mu, "Jm": self.jm}


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

    mu: float
    lm: float

    def __post_init__(self) -> None:
        if not 0 < self.lm < np.inf:
            raise PalpateError(
                f"Arruda–Boyce's lm is {self.lm:g}.", "It is the stretch of a straight chain: give a positive number."
            )

    @property
    def name(self) -> str:
        return "arruda-boyce"

    @property
    def code(self) -> int:
        return ARRUDA_BOYCE

    @property
    def parameters(self) -> FloatArray:
        return np.array([self.mu, self.lm])

    @property
    def shear_modulus(self) -> float:
        terms = ((i + 1) * factor * (3 / self.lm**2) ** i for i, factor in enumerate(CHAIN))
        return 2 * self.mu * sum(terms)

    @property
    def constants(self) -> dict[str, float]:
        return {"mu": self.mu, "lm": self.lm}


def gent(mu: float, jm: float) -> Gent:
    """Gent's law from mu (MPa) and Jm."""
    return Gent(mu, jm)


def arruda_boyce(mu: float, lm: float) -> ArrudaBoyce:
    """Arruda and Boyce's law from mu (MPa) and the locking stretch lm."""
    return ArrudaBoyce(mu, lm)
