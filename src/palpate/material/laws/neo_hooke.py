"""The neo-Hookean law: chains of Gaussian statistics.

Reference: Treloar, *Trans. Faraday Soc.* 39 (1943) 241.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from palpate.material.law import Model
from palpate.material.laws.polynomial import PolynomialLaw
from palpate.material.model import LinearModel


@final
@dataclass(frozen=True)
class NeoHooke(PolynomialLaw):
    """Neo-Hooke ``W = C10 (I1-3)``, C10 in MPa; the shear modulus is 2 C10."""

    name: ClassVar[str] = "neo-hooke"

    C10: float = 0.0

    @classmethod
    def models(cls) -> Sequence[Model]:
        return (LinearModel("neo-hooke", cls, ("C10",)),)
