"""Mooney's and Rivlin's law, of the first and second order.

References: Mooney, *J. Appl. Phys.* 11 (1940) 582; Rivlin, *Phil. Trans. R. Soc. A* 241 (1948) 379.
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
class MooneyRivlin(PolynomialLaw):
    """Mooney–Rivlin ``W = C10 (I1-3) + C01 (I2-3)``, coefficients in MPa.

    With C11 ``+ C11 (I1-3)(I2-3)``, and of the second order ``+ C20 (I1-3)² + C11 (I1-3)(I2-3) + C02 (I2-3)²``.
    """

    name: ClassVar[str] = "mooney-rivlin"
    forms: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("C10", "C01"),
        ("C10", "C01", "C11"),
        ("C10", "C01", "C20", "C11", "C02"),
    )

    C10: float = 0.0
    C01: float = 0.0
    C20: float = 0.0
    C11: float = 0.0
    C02: float = 0.0

    @classmethod
    def models(cls) -> Sequence[Model]:
        return tuple(
            LinearModel("mooney-rivlin" + (f"-{len(form)}" if len(form) > 2 else ""), cls, form) for form in cls.forms
        )
