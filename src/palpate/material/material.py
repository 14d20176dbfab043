"""Material: isochoric law, volumetric part, and origin of the constants."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.material.law import Law
from palpate.material.relaxation import Relaxation

DEFAULT_BULK_RATIO = 2000.0
"""K / mu of a silicone in this package: nearly incompressible (Poisson's ratio 0.49975)."""


@dataclass(frozen=True)
class Material:
    """Nearly incompressible hyperelastic material, ``W = W_iso(F_bar) + K/2 (J - 1)²``.

    Attributes
    ----------
    name
        Name in the library, or the text it was made from.
    law
        Isochoric part.
    bulk_ratio
        Bulk over initial shear modulus, K / mu, at least 2.
    source
        Reference of the numbers.
    stretch_range
        Uniaxial stretches within which the numbers were measured.
    licence
        Licence of the numbers or of the data behind them.
    quality
        Quality of the law for its data.
    caution
        Warning for the user.
    gel
        Gel that fills a skin of this material, bonded to it and to its window; `None`: it is hollow.
    relaxation
        Relaxation of its stress at constant strain; `None`: it does not relax.
    """

    name: str
    law: Law
    bulk_ratio: float = DEFAULT_BULK_RATIO
    source: str = ""
    stretch_range: tuple[float, float] = (0.0, np.inf)
    licence: str = ""
    quality: str = ""
    caution: str = ""
    gel: Material | None = None
    relaxation: Relaxation | None = None

    def __post_init__(self) -> None:
        if not (np.isfinite(self.law.shear_modulus) and self.law.shear_modulus > 0):
            raise PalpateError(
                f"Material {self.name} has the initial shear modulus {self.law.shear_modulus:.4g} MPa.",
                "It must be positive: check sign and unit (MPa) of the coefficients.",
                code="shear-modulus-not-positive",
            )
        if not 2 <= self.bulk_ratio <= 1e7:
            raise PalpateError(
                f"The bulk ratio K/mu is {self.bulk_ratio:.4g}.",
                "Choose one between 2 and 1e7.",
                code="bulk-ratio-out-of-bounds",
            )

    @property
    def has_gel(self) -> bool:
        """Whether a skin of this material is filled with a gel."""
        return self.gel is not None

    @property
    def bulk_modulus(self) -> float:
        """K, MPa."""
        return self.bulk_ratio * self.law.shear_modulus

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio at rest, ``(3K - 2mu) / (6K + 2mu)``."""
        return (3 * self.bulk_ratio - 2) / (6 * self.bulk_ratio + 2)

    @property
    def young_modulus(self) -> float:
        """Young's modulus at rest, MPa."""
        return 2 * self.law.shear_modulus * (1 + self.poisson_ratio)

    @property
    def whole_relaxation(self) -> Relaxation | None:
        """Relaxation of a whole skin, gel included.

        Raises
        ------
        PalpateError
            If gel and skin have different relaxations: no single function describes the skin then.
        """
        if self.gel is not None and self.gel.relaxation != self.relaxation:
            raise PalpateError(
                f"The gel {self.gel.name} relaxes otherwise than its wall {self.name}.",
                "Give both materials the same relaxation, or neither: one function serves the whole skin.",
                code="gel-relaxes-otherwise",
            )
        return self.relaxation

    def with_bulk_ratio(self, bulk_ratio: float) -> Material:
        """Return the same material with another K / mu."""
        return replace(self, bulk_ratio=bulk_ratio)

    def key_data(self) -> dict[str, Any]:
        """Return the identity as plain values; the name does not matter.

        Law, constants (MPa) and bulk ratio; relaxation and gel if present.
        """
        own: dict[str, Any] = {
            "law": self.law.name,
            "constants": self.law.constants,
            "bulk_ratio": self.bulk_ratio,
        }
        if self.relaxation is not None:
            own["relaxation"] = self.relaxation.key_data()
        return own if self.gel is None else {**own, "gel": {"name": self.gel.name, **self.gel.key_data()}}

    def evaluate(self, F: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Evaluate the isochoric part at many deformation gradients.

        Parameters
        ----------
        F
            (n, 3, 3) deformation gradients.

        Returns
        -------
        energy, tau, c
            (n,), (n, 6), (n, 6, 6) MPa: energy, isochoric Kirchhoff stress and spatial tangent (Voigt).
        """
        return self.law.isochoric(np.ascontiguousarray(F, float))
