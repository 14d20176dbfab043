"""Closed-form curves of an incompressible material in the tests of a laboratory."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from palpate.core import FloatArray
from palpate.material.material import Material


class Mode(StrEnum):
    """Homogeneous test: which principal stretches are imposed."""

    UNIAXIAL = "uniaxial"
    EQUIBIAXIAL = "equibiaxial"
    PLANAR = "planar"


@dataclass(frozen=True)
class Curve:
    """Response of an incompressible material in one mode.

    Attributes
    ----------
    mode
        The test.
    stretch
        (n,) stretch of the pulled direction.
    nominal
        (n,) nominal (first Piola–Kirchhoff) stress of the pulled direction, MPa.
    cauchy
        (n,) Cauchy stress of the pulled direction, MPa.
    cauchy_constraint
        (n,) Cauchy stress of the second direction, MPa (zero in uniaxial tension).
    energy
        (n,) MPa.
    """

    mode: Mode
    stretch: FloatArray
    nominal: FloatArray
    cauchy: FloatArray
    cauchy_constraint: FloatArray
    energy: FloatArray


def stretches(mode: Mode, stretch: FloatArray) -> FloatArray:
    """Principal stretches (n, 3) of an incompressible test at the stretch (n,) of its pulled direction."""
    lam = np.asarray(stretch, float)
    one = np.ones_like(lam)
    second = {Mode.UNIAXIAL: lam**-0.5, Mode.EQUIBIAXIAL: lam, Mode.PLANAR: one}[mode]
    return np.stack([lam, second, 1 / (lam * second)], axis=-1)


def uniaxial_range(mode: Mode, low: float, high: float) -> tuple[float, float]:
    """Uniaxial stretches with the same invariant I1 as the stretches low…high, on the same side of rest.

    Exact between equibiaxial tension and uniaxial compression, which are one state; a planar stretch is unchanged.
    """
    return (float(high) ** -2, float(low) ** -2) if mode is Mode.EQUIBIAXIAL else (float(low), float(high))


def trace_curve(material: Material, mode: Mode, stretch: FloatArray) -> Curve:
    """Trace the incompressible response, the third direction free of stress.

    ``sigma_1 = tau_1 - tau_3``, ``P_1 = sigma_1 / lambda_1``: the pressure follows from ``sigma_3 = 0``.
    """
    principal = stretches(mode, stretch)
    energy, tau, _ = material.evaluate(principal[:, :, None] * np.eye(3))
    cauchy = tau[:, 0] - tau[:, 2]
    return Curve(
        mode=mode,
        stretch=principal[:, 0],
        nominal=cauchy / principal[:, 0],
        cauchy=cauchy,
        cauchy_constraint=tau[:, 1] - tau[:, 2],
        energy=energy,
    )
