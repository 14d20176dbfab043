"""A skin whose meridian is a cosine: a bell."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from palpate.core import FloatArray
from palpate.design import RevolvedSkin, SkinSpec


@dataclass(frozen=True)
class Bell(RevolvedSkin):
    """``rho = B t``, ``z = H cos(pi t / 2)``."""

    height: float
    base_radius: float
    thickness: float

    @property
    def shape(self) -> str:
        return "bell"

    @property
    def spec_data(self) -> dict[str, Any]:
        return {"kind": "bell", **asdict(self)}

    @property
    def radius(self) -> float:
        return self.base_radius**2 / (self.height * (np.pi / 2) ** 2)

    def scaled(self, factor: float) -> "Bell":
        return Bell(*(factor * size for size in (self.height, self.base_radius, self.thickness)))

    def curve(self, t: FloatArray, order: int = 0) -> FloatArray:
        phase = t * np.pi / 2 + order * np.pi / 2
        rho = [self.base_radius * t, np.full_like(t, self.base_radius), np.zeros_like(t)][order]
        return np.column_stack([rho, self.height * (np.pi / 2) ** order * np.cos(phase)])


class BellSpec(SkinSpec):
    """A bell with a wall of even thickness."""

    kind: Literal["bell"] = "bell"

    def build(self) -> Bell:
        return Bell(self.height, self.base_radius, self.thickness)
