"""Compiled kernels: isochoric energy, Kirchhoff stress and spatial tangent of every law at one point.

With ``b_bar = J**(-2/3) F F^T`` the isochoric Kirchhoff stress of a function of the invariants is (Holzapfel 2000,
eqs. 6.90-6.110, in spatial form)

    tau = dev(tau_f),  tau_f = 2 (W1 + I1 W2) b_bar - 2 W2 b_bar²
    c   = P : c_f : P + 2/3 tr(tau_f) P - 2/3 (I ⊗ tau + tau ⊗ I),  P = II - 1/3 I ⊗ I

which for a function of I1 alone (Gent, Arruda–Boyce) is ``tau_f = 2 W1 b_bar``, ``c_f = 4 W11 b_bar ⊗ b_bar``;
and for Ogden, in principal axes with ``e_a = ln l_a`` (Simo & Taylor 1991),

    tau_a = sum_k mu_k (l_a^alpha_k - 1/3 sum_b l_b^alpha_k)
    c     = sum_ab (d tau_a/d e_b - 2 tau_a delta_ab) m_a ⊗ m_b + shear terms between unequal axes.

Tensors are in Voigt order xx, yy, zz, xy, yz, zx; the tangent multiplies engineering shear strains.
"""

from __future__ import annotations

import numpy as np

from palpate.core import kernel
from palpate.material.law import ARRUDA_BOYCE, GENT, OGDEN, FloatArray
from palpate.material.locking import CHAIN

_EQUAL = 1e-6
"""Relative distance below which two principal stretches count as equal."""


@kernel
def isochoric(code: int, parameters: FloatArray, F: FloatArray, tau: FloatArray, c: FloatArray) -> float:
    """Evaluate the isochoric part of a law.

    Parameters
    ----------
    code, parameters
        Of the `palpate.material.law.Law`.
    F
        (3, 3) deformation gradient with positive determinant.
    tau
        (6,) receives the isochoric Kirchhoff stress, MPa.
    c
        (6, 6) receives the spatial tangent, MPa.

    Returns
    -------
    float
        Energy per undeformed volume, MPa; infinite beyond the stretch at which Gent's chains lock.
    """
    if code == OGDEN:
        return _ogden(parameters, F, tau, c)
    if code in (GENT, ARRUDA_BOYCE):
        return _locking(code, parameters, F, tau, c)
    return _polynomial(parameters, F, tau, c)


@kernel
def isochoric_at_all(
    code: int, parameters: FloatArray, F: FloatArray, energy: FloatArray, tau: FloatArray, c: FloatArray
) -> None:
    """Evaluate the isochoric part at n points: as `isochoric`, every array with n in front, energy (n,)."""
    for i in range(len(F)):
        energy[i] = isochoric(code, parameters, F[i], tau[i], c[i])


@kernel
def _left_cauchy_green(F: FloatArray, b: FloatArray) -> float:
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
def _add_symmetric_square(factor: float, b: FloatArray, c: FloatArray) -> None:
    """Add ``factor`` times the push-forward of the symmetric identity, ``(b_ik b_jl + b_il b_jk) / 2``."""
    first = (0, 1, 2, 0, 1, 2)
    second = (0, 1, 2, 1, 2, 0)
    at = ((0, 3, 5), (3, 1, 4), (5, 4, 2))
    for p in range(6):
        i, j = first[p], second[p]
        for q in range(6):
            k, l = first[q], second[q]
            c[p, q] += factor * 0.5 * (b[at[i][k]] * b[at[j][l]] + b[at[i][l]] * b[at[j][k]])


@kernel
def _polynomial(parameters: FloatArray, F: FloatArray, tau: FloatArray, c: FloatArray) -> float:
    c10, c01, c20, c11, c02, c30 = parameters
    b = np.empty(6)
    _left_cauchy_green(F, b)
    b2 = np.empty(6)
    b2[0] = b[0] * b[0] + b[3] * b[3] + b[5] * b[5]
    b2[1] = b[3] * b[3] + b[1] * b[1] + b[4] * b[4]
    b2[2] = b[5] * b[5] + b[4] * b[4] + b[2] * b[2]
    b2[3] = b[0] * b[3] + b[3] * b[1] + b[5] * b[4]
    b2[4] = b[3] * b[5] + b[1] * b[4] + b[4] * b[2]
    b2[5] = b[5] * b[0] + b[4] * b[3] + b[2] * b[5]
    I1 = b[0] + b[1] + b[2]
    I2 = 0.5 * (I1 * I1 - b2[0] - b2[1] - b2[2])
    x, y = I1 - 3.0, I2 - 3.0
    W1 = c10 + 2.0 * c20 * x + c11 * y + 3.0 * c30 * x * x
    W2 = c01 + c11 * x + 2.0 * c02 * y
    W11 = 2.0 * c20 + 6.0 * c30 * x
    W12, W22 = c11, 2.0 * c02
    trace = 0.0
    for p in range(6):
        tau[p] = 2.0 * (W1 + I1 * W2) * b[p] - 2.0 * W2 * b2[p]
    trace = tau[0] + tau[1] + tau[2]
    bb = 4.0 * (W11 + 2.0 * I1 * W12 + W2 + I1 * I1 * W22)
    b_b2 = -4.0 * (W12 + I1 * W22)
    b2_b2 = 4.0 * W22
    for p in range(6):
        for q in range(6):
            c[p, q] = bb * b[p] * b[q] + b_b2 * (b[p] * b2[q] + b2[p] * b[q]) + b2_b2 * b2[p] * b2[q]
    if W2 != 0.0:
        _add_symmetric_square(-4.0 * W2, b, c)
    _project(c)
    for p in range(3):
        tau[p] -= trace / 3.0
    _add_projector(trace, tau, c)
    return c10 * x + c01 * y + c20 * x * x + c11 * x * y + c02 * y * y + c30 * x * x * x


@kernel
def _locking(code: int, parameters: FloatArray, F: FloatArray, tau: FloatArray, c: FloatArray) -> float:
    b = np.empty(6)
    _left_cauchy_green(F, b)
    I1 = b[0] + b[1] + b[2]
    mu = parameters[0]
    energy, W1, W11 = 0.0, 0.0, 0.0
    if code == GENT:
        left = 1.0 - (I1 - 3.0) / parameters[1]
        if left > 0.0:
            energy = -0.5 * mu * parameters[1] * np.log(left)
            W1 = 0.5 * mu / left
            W11 = W1 / (left * parameters[1])
        else:
            energy = np.inf
    else:
        slack = 1.0 / (parameters[1] * parameters[1])
        scale, power = mu, 1.0
        for i in range(len(CHAIN)):
            order = i + 1.0
            energy += scale * CHAIN[i] * (power * I1 - 3.0**order)
            W1 += scale * CHAIN[i] * order * power
            W11 += scale * CHAIN[i] * order * (order - 1.0) * power / I1
            scale *= slack
            power *= I1
    for p in range(6):
        tau[p] = 2.0 * W1 * b[p]
        for q in range(6):
            c[p, q] = 4.0 * W11 * b[p] * b[q]
    trace = tau[0] + tau[1] + tau[2]
    _project(c)
    for p in range(3):
        tau[p] -= trace / 3.0
    _add_projector(trace, tau, c)
    return energy


@kernel
def _project(c: FloatArray) -> None:
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
def _add_projector(trace: float, tau: FloatArray, c: FloatArray) -> None:
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
def _ogden(parameters: FloatArray, F: FloatArray, tau: FloatArray, c: FloatArray) -> float:
    terms = len(parameters) // 2
    b = np.empty(6)
    _left_cauchy_green(F, b)
    matrix = np.empty((3, 3))
    matrix[0, 0], matrix[1, 1], matrix[2, 2] = b[0], b[1], b[2]
    matrix[0, 1] = matrix[1, 0] = b[3]
    matrix[1, 2] = matrix[2, 1] = b[4]
    matrix[0, 2] = matrix[2, 0] = b[5]
    square, axis = np.linalg.eigh(matrix)
    beta = np.zeros(3)
    slope = np.zeros((3, 3))
    energy = 0.0
    for k in range(terms):
        mu, alpha = parameters[k], parameters[terms + k]
        power = square ** (0.5 * alpha)
        total = power[0] + power[1] + power[2]
        energy += mu / alpha * (total - 3.0)
        for a in range(3):
            beta[a] += mu * (power[a] - total / 3.0)
            for d in range(3):
                slope[a, d] += mu * alpha * (total / 9.0 - (power[a] + power[d]) / 3.0)
            slope[a, a] += mu * alpha * power[a]
    tau[:] = 0.0
    c[:, :] = 0.0
    m = np.empty(6)
    n = np.empty(6)
    for a in range(3):
        _dyad(axis, a, a, m)
        for p in range(6):
            tau[p] += beta[a] * m[p]
        for d in range(3):
            _dyad(axis, d, d, n)
            factor = slope[a, d] - (2.0 * beta[a] if a == d else 0.0)
            for p in range(6):
                for q in range(6):
                    c[p, q] += factor * m[p] * n[q]
        for d in range(a):
            _dyad(axis, a, d, m)
            gap = square[a] - square[d]
            if abs(gap) > _EQUAL * (square[a] + square[d]):
                factor = (beta[a] * square[d] - beta[d] * square[a]) / gap
            else:
                mean = 0.25 * (slope[a, a] - slope[a, d] + slope[d, d] - slope[d, a])
                factor = mean - 0.5 * (beta[a] + beta[d])
            for p in range(6):
                for q in range(6):
                    c[p, q] += 4.0 * factor * m[p] * m[q]
    return energy


@kernel
def _dyad(axis: FloatArray, a: int, d: int, m: FloatArray) -> None:
    """Write the symmetric dyad of two principal axes (columns of `axis`)."""
    m[0] = axis[0, a] * axis[0, d]
    m[1] = axis[1, a] * axis[1, d]
    m[2] = axis[2, a] * axis[2, d]
    m[3] = 0.5 * (axis[0, a] * axis[1, d] + axis[1, a] * axis[0, d])
    m[4] = 0.5 * (axis[1, a] * axis[2, d] + axis[2, a] * axis[1, d])
    m[5] = 0.5 * (axis[2, a] * axis[0, d] + axis[0, a] * axis[2, d])
