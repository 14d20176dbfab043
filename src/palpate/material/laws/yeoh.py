"""Yeoh's law.

Reference: Yeoh, *Rubber Chem. Technol.* 66 (1993) 754.
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
class Yeoh(PolynomialLaw):
    """Yeoh ``W = C10 (I1-3) + C20 (I1-3)² + C30 (I1-3)³``, coefficients in MPa."""

    name: ClassVar[str] = "yeoh"

    C10: float = 0.0
    C20: float = 0.0
    C30: float = 0.0

    @classmethod
    def models(cls) -> Sequence[Model]:
        return (LinearModel("yeoh", cls, ("C10", "C20", "C30")),)
