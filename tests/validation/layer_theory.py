"""A rigid, frictionless ball or bar on an incompressible layer bonded to a rigid base, by integral equations.

In the transform over the plane, a pressure p lowers the surface by ``(1 - nu)/mu · L(k h)/k · p``, for ``nu = 1/2``
``L(w) = (sinh 2w - 2w) / (cosh 2w + 2w² + 1)`` (Lebedev & Ufliand 1958; Hayes, Keer, Herrmann & Mockros 1972, *J.
Biomech.* 5, 541). *Ball*: dual integral equations, reduced to one of Fredholm for the function whose integral is the
force. *Bar*, in plane strain: Cauchy's singular equation, by Gauss-Chebyshev quadrature (Erdogan & Gupta 1972, *Q.
Appl. Math.* 29, 525). Both know small strain alone; a far base gives Hertz.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray

_POINTS, _WAVES, _MOST = 61, 400, 30.0
"""Points across the contact (one in its middle), wave numbers, and the greatest of these times the thickness."""


def _lowering(w: FloatArray) -> FloatArray:
    """L(w): 1 far above the base, 2/3 w³ close to it."""
    return np.asarray((np.sinh(2 * w) - 2 * w) / (np.cosh(2 * w) + 2 * w**2 + 1))


def ball_on_layer(contact: float, thickness: float, radius: float, shear_modulus: float) -> tuple[float, float]:
    """Depth (mm) and force (N) of a ball that touches a layer within a radius of contact.

    Parameters
    ----------
    contact, thickness, radius
        Radius of contact, thickness of the layer, radius of the ball, mm.
    shear_modulus
        MPa.
    """
    node, weight = np.polynomial.legendre.leggauss(_POINTS)
    t, dt = 0.5 * contact * (1 + node), 0.5 * contact * weight
    waves, dk = np.polynomial.legendre.leggauss(_WAVES)
    k, dk = 0.5 * _MOST / thickness * (1 + waves), 0.5 * _MOST / thickness * dk
    loss = dk * (_lowering(k * thickness) - 1)

    def kernel(at: FloatArray) -> FloatArray:
        return np.asarray(2 / np.pi * (np.cos(np.outer(at, k)) * loss) @ np.cos(np.outer(k, t)) * dt)

    # of a flat punch of depth 1, and of a paraboloid that comes no deeper than 0
    flat, round_ = np.linalg.solve(np.eye(_POINTS) + kernel(t), np.stack([np.ones_like(t), -(t**2) / radius], 1)).T
    rim = kernel(np.array([contact]))[0]
    depth = -(-(contact**2) / radius - rim @ round_) / (1 - rim @ flat)  # the pressure ends smoothly
    return float(depth), float(8 * shear_modulus * (depth * flat + round_) @ dt)


def bar_on_layer(contact: float, thickness: float, radius: float, shear_modulus: float) -> tuple[float, float]:
    """Depth (mm) and force (N over a mm) of a long bar that touches a layer within a half width of contact.

    Parameters
    ----------
    contact, thickness, radius
        Half width of contact, thickness of the layer, radius of the bar, mm.
    shear_modulus
        MPa.
    """
    j, i = np.arange(1, _POINTS + 1), np.arange(1, _POINTS + 2)
    s, x = (contact * np.cos(np.pi * each / (_POINTS + 1)) for each in (j, i - 0.5))
    waves, dk = np.polynomial.legendre.leggauss(_WAVES)
    k, dk = 0.5 * _MOST / thickness * (1 + waves), 0.5 * _MOST / thickness * dk
    apart = x[:, None] - s
    near = 1 / apart - np.sin(apart[..., None] * k) @ (dk * (1 - _lowering(k * thickness)))
    share = np.sin(np.pi * j / (_POINTS + 1)) ** 2 / (_POINTS + 1)
    # p(s) = sqrt(1 - (s/a)²) · shape, its quadrature with the weights π · share
    slope = 2 * shear_modulus * x / radius
    shape = np.linalg.lstsq(contact * near * share, slope, rcond=None)[0]
    weight = contact * np.pi * share
    far = np.cos(np.outer(s, k)) @ (dk / k * (_lowering(k * thickness) - 1 + np.exp(-k * thickness)))
    smooth = 0.5 * np.log(s**2 + thickness**2) + far
    # what is lowered in the middle is infinite like -ln |s|, whose integral is known where the shape is even
    middle = shape[_POINTS // 2]
    sharp = (weight * (shape - middle)) @ np.log(np.abs(s)) + middle * 0.5 * np.pi * contact * (
        np.log(0.5 * contact) - 0.5
    )
    lowered = (weight * shape) @ smooth - sharp
    return float(lowered / (2 * np.pi * shear_modulus)), float((weight * shape).sum())
