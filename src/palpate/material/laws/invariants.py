"""Common parts of laws in the invariants: ``b_bar``, and stress and tangent from ``tau_f``, compiled.

With ``b_bar = J**(-2/3) F F^T`` the isochoric Kirchhoff stress of a function of the invariants
``I1 = tr(b_bar)`` and ``I2 = (I1² - tr(b_bar²)) / 2`` is (Holzapfel 2000, eqs. 6.90-6.110, in spatial form)

    tau = dev(tau_f),  tau_f = 2 (W1 + I1 W2) b_bar - 2 W2 b_bar²
    c   = P : c_f : P + 2/3 tr(tau_f) P - 2/3 (I ⊗ tau + tau ⊗ I),  P = II - 1/3 I ⊗ I

which for a function of I1 alone is ``tau_f = 2 W1 b_bar``, ``c_f = 4 W11 b_bar ⊗ b_bar``. Tensors are in Voigt order
xx, yy, zz, xy, yz, zx; the tangent multiplies engineering shear strains.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, kernel


@kernel
def left_cauchy_green(F: FloatArray, b: FloatArray) -> float:
    """Write ``b_bar`` (6,) and return the determinant of F."""
    J = (
        F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1])
        - F[0, 1] * (F[1, 0] * F[2, 2] - F[1, 2] * F[2, 0])
        + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0])
    )
    scale = J ** (-2.0 / 3.0)
    b[0] = scale * (F[0, 0] * F[0, 0] + F[0, 1] * F[0, 1] + F[0, 2] * F[0, 2])
    b[1] = scale * (F[1, 0] * F[1, 0] + F[1, 1] * F[1, 1] + F[1, 2] * F[1, 2])
    b[2] = scale * (F[2, 0] * F[2, 0] + F[2, 1] * F[2, 1] + F[2, 2] * F[2, 2])
    b[3] = scale * (F[0, 0] * F[1, 0] + F[0, 1] * F[1, 1] + F[0, 2] * F[1, 2])
    b[4] = scale * (F[1, 0] * F[2, 0] + F[1, 1] * F[2, 1] + F[1, 2] * F[2, 2])
    b[5] = scale * (F[2, 0] * F[0, 0] + F[2, 1] * F[0, 1] + F[2, 2] * F[0, 2])
    return J


@kernel
def project(c: FloatArray) -> None:
    """Replace c by ``P : c : P``."""
    for q in range(6):
        mean = (c[0, q] + c[1, q] + c[2, q]) / 3.0
        c[0, q] -= mean
        c[1, q] -= mean
        c[2, q] -= mean
    for p in range(6):
        mean = (c[p, 0] + c[p, 1] + c[p, 2]) / 3.0
        c[p, 0] -= mean
        c[p, 1] -= mean
        c[p, 2] -= mean


@kernel
def add_projector(trace: float, tau: FloatArray, c: FloatArray) -> None:
    """Add ``2/3 tr(tau_f) P - 2/3 (I ⊗ tau + tau ⊗ I)``."""
    for p in range(6):
        c[p, p] += (2.0 / 3.0) * trace * (1.0 if p < 3 else 0.5)
    for p in range(3):
        for q in range(3):
            c[p, q] -= (2.0 / 9.0) * trace
        for q in range(6):
            c[p, q] -= (2.0 / 3.0) * tau[q]
            c[q, p] -= (2.0 / 3.0) * tau[q]


@kernel
def first_invariant(W1: float, W11: float, b: FloatArray, tau: FloatArray, c: FloatArray) -> None:
    """Write stress tau (6,) and tangent c (6, 6) of a function of I1 with derivatives W1, W11 at b (6,)."""
    for p in range(6):
        tau[p] = 2.0 * W1 * b[p]
        for q in range(6):
            c[p, q] = 4.0 * W11 * b[p] * b[q]
    trace = tau[0] + tau[1] + tau[2]
    project(c)
    for p in range(3):
        tau[p] -= trace / 3.0
    add_projector(trace, tau, c)


def answers(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Empty arrays for energy (n,), stress (n, 6) and tangent (n, 6, 6)."""
    return np.empty(count), np.empty((count, 6)), np.empty((count, 6, 6))


def stretched(principal: FloatArray) -> FloatArray:
    """``I1 - 3`` (n,) in principal stretches (n, 3)."""
    return np.asarray((principal**2).sum(axis=1) - 3)


def drive(principal: FloatArray) -> FloatArray:
    """``2 (l1 - l3²/l1)`` (n,): nominal stress of a function of I1 over W1."""
    return np.asarray(2 * (principal[:, 0] - principal[:, 2] ** 2 / principal[:, 0]))
