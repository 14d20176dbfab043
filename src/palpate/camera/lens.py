"""Interface of a lens: projection of a direction, and its inverse.

A lens maps the plane at unit distance, ``(x/z, y/z)`` of a point in front of the camera, onto itself; focal lengths
and principal point then give pixels. Each lens is in a file of `palpate.camera.lenses`, or in another package that
names it in its entry points (group ``palpate.lenses``). `palpate.testing.LensSuite` tests a lens against this
interface.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from palpate.core import FloatArray, PalpateError, Registry


@dataclass(frozen=True)
class Lens(ABC):
    """A lens; an implementer is a frozen dataclass whose fields are its coefficients, all zero by default.

    Attributes
    ----------
    name
        Name in a spec, ``camera: {lens: name}``, and of its entry point.
    model
        Name in calibration files, as in ROS; equal to `name` if empty.
    refinable
        Coefficients that one rest image may refine with the camera's pose, with their prior standard deviations:
        those between copies of the lens.
    leading
        Coefficient of the lowest order of the radial distortion, which a calibration error changes first; may be
        empty.
    """

    name: ClassVar[str]
    model: ClassVar[str] = ""
    refinable: ClassVar[Mapping[str, float]] = {}
    leading: ClassVar[str] = ""

    @property
    @abstractmethod
    def max_radius(self) -> float:
        """Maximum radius on the unit plane at which the lens is valid, infinite for most; it folds beyond."""

    @abstractmethod
    def distort(self, points: FloatArray) -> FloatArray:
        """Return the distorted points (..., 2) of ideal points (..., 2) on the unit plane; NaN stays NaN."""

    @abstractmethod
    def undistort(self, points: FloatArray) -> FloatArray:
        """Return the ideal points (..., 2) of distorted ones (..., 2); `distort` inverts this to 1e-9.

        Raises
        ------
        PalpateError
            If a point is outside the image of this lens; `folded` makes the error.
        """

    @abstractmethod
    def mirrored(self) -> Self:
        """Return the lens of the same image with left and right exchanged."""

    @cached_property
    def coefficients(self) -> tuple[float, ...]:
        """Values of the coefficients, in the order of `parameters`."""
        return tuple(getattr(self, one.name) for one in fields(self))

    @classmethod
    def parameters(cls) -> tuple[str, ...]:
        """Return the names of the coefficients."""
        return tuple(item.name for item in fields(cls))


LENSES: Registry[type[Lens]] = Registry(
    "palpate.lenses",
    "lens",
    {
        "brown": "palpate.camera.lenses.brown:Brown",
        "kannala-brandt": "palpate.camera.lenses.kannala_brandt:KannalaBrandt",
        "rational": "palpate.camera.lenses.rational:Rational",
    },
    fits=lambda found: isinstance(found, type) and issubclass(found, Lens),
)
"""Lenses by name."""

_ALIASES = {
    **dict.fromkeys(("radtan", "radial_tangential"), "plumb_bob"),
    "brown": "plumb_bob",
    "brown_conrady": "plumb_bob",
    "fisheye": "equidistant",
    "equi": "equidistant",
    "kannala_brandt": "equidistant",
    "kannala_brandt4": "equidistant",
    "rational": "rational_polynomial",
    "thin_prism": "rational_polynomial",
}
_ITERATIONS, _TOLERANCE = 50, 1e-10
"""Maximum Newton steps of an inverse lens model, and residual at which they end, normalised."""


def make_lens(name: str, coefficients: Sequence[float]) -> Lens:
    """Make a lens from its coefficients.

    Raises
    ------
    PalpateError
        If the lens is unknown, or has another number of coefficients.
    """
    kind: Any = LENSES.get(name)
    names = kind.parameters()
    if len(coefficients) != len(names):
        raise PalpateError(
            f"The lens {name} has {len(names)} coefficients; got {len(coefficients)}.",
            f"Give {', '.join(names)}.",
            code="lens-coefficient-count",
        )
    lens: Lens = kind(*coefficients)
    return lens


def lens_from_model(model: str) -> type[Lens] | None:
    """Return the lens of a model's name in a calibration file; `None` if it is unknown."""
    plain = model.lower().replace("-", "_").removeprefix("distortion.")
    wanted = _ALIASES.get(plain, plain)
    return next((lens for _, lens in LENSES.available() if wanted in (lens.model, lens.name.replace("-", "_"))), None)


def fold_of(slopes: Sequence[float]) -> float:
    """Return the smallest zero r > 0 of ``1 + a r² + b r⁴ + …`` by its coefficients; infinite without one."""
    # in 1/r² the leading coefficient is 1, so vanishing coefficients do no harm
    inverse = max((root.real for root in np.roots(slopes) if abs(root.imag) < 1e-12), default=0.0)
    return float(1.0 / np.sqrt(inverse)) if inverse > 1e-9 else float("inf")


def undistort_by_newton(
    lens: Lens, slope: Callable[[FloatArray], FloatArray], points: FloatArray, iterations: int = _ITERATIONS
) -> FloatArray:
    """Return the ideal points (..., 2) of distorted ones (..., 2) by Newton's iteration.

    Parameters
    ----------
    lens
        The lens, which distorts.
    slope
        (..., 2, 2) derivative of its `distort` at points (..., 2); if that is singular, the identity is used.
    points
        Distorted points.
    iterations
        Maximum number of iterations.

    Raises
    ------
    PalpateError
        If it does not converge, or ends beyond the fold of the lens.
    """
    ideal = np.array(points, dtype=float)
    for _ in range(iterations):
        miss = lens.distort(ideal) - points
        if not np.any(np.abs(miss) > _TOLERANCE):
            break
        matrix = slope(ideal)
        singular = np.abs(np.linalg.det(matrix)) < 1e-9
        matrix = np.where(singular[..., None, None], np.eye(2), matrix)
        ideal -= np.linalg.solve(matrix, miss[..., None])[..., 0]
    worst = float(np.max(np.abs(lens.distort(ideal) - points), initial=0.0))
    radius = float(np.max(np.linalg.norm(ideal, axis=-1), initial=0.0))
    if not worst <= _TOLERANCE * 10.0 or radius > lens.max_radius:
        raise folded(lens.max_radius)
    return ideal


def folded(limit: float) -> PalpateError:
    """Return the error of a pixel outside the image of a lens."""
    return PalpateError(
        f"The lens distortion folds at radius {limit:.3g}, so a pixel cannot be traced back.",
        "Use points closer to the centre of the image, or coefficients fitted over the whole image.",
        code="lens-folds",
    )
