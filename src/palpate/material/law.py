"""Interface of hyperelastic laws, and of the models by which a law is fitted.

Every law is isotropic and gives the isochoric part of the strain energy, a function of ``F_bar = J**(-1/3) F``; the
volumetric part is that of `palpate.material.Material`. Each law has a file in `palpate.material.laws`, or a package
that names it in its entry points (group ``palpate.laws``); `palpate.testing.LawSuite` tests this interface.

Reference: Holzapfel, *Nonlinear Solid Mechanics* (2000), sections 6.4-6.6.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from palpate.core import FloatArray, PalpateError


class DeckLine(NamedTuple):
    """A law in the constants of Abaqus and CalculiX.

    Attributes
    ----------
    parameter
        Parameter of ``*HYPERELASTIC``.
    constants
        MPa and pure numbers, those of the volumetric part left out.
    volumetric
        Number of the volumetric constants D1, D2, … after them.
    """

    parameter: str
    constants: tuple[float, ...]
    volumetric: int = 1


@dataclass(frozen=True)
class Law(ABC):
    """Isochoric strain energy of an isotropic hyperelastic material.

    An implementation is a frozen dataclass whose fields are the constants, by the names of the literature, in MPa or
    as pure numbers; a field with a default is optional.

    Attributes
    ----------
    name
        Name on the command line and in files, e.g. ``yeoh``; the name of its entry point.
    forms
        Constants in the order in which the user writes them, one form for each count; empty: all fields.
    """

    name: ClassVar[str]
    forms: ClassVar[tuple[tuple[str, ...], ...]] = ()

    @property
    @abstractmethod
    def shear_modulus(self) -> float:
        """Initial shear modulus, MPa."""

    @abstractmethod
    def isochoric(self, F: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Evaluate the law at n points.

        Parameters
        ----------
        F
            (n, 3, 3) deformation gradients of positive determinant, contiguous.

        Returns
        -------
        energy, tau, c
            (n,), (n, 6), (n, 6, 6) MPa, new arrays: energy per undeformed volume (infinite beyond a stretch at which
            the law locks), isochoric Kirchhoff stress, and its spatial tangent, which gives the Lie derivative
            ``L_v tau = c : d``; Voigt order xx, yy, zz, xy, yz, zx, the tangent multiplies engineering shear strains.
        """

    @abstractmethod
    def scaled(self, modulus: float, stiffening: float = 1.0) -> Self:
        """Return the law with its stress times `modulus`, and higher-order constants times `stiffening` too.

        Raises
        ------
        PalpateError
            If stiffening is not 1 and the law has no constants of higher order.
        """

    @abstractmethod
    def deck(self) -> DeckLine | None:
        """Deck keywords of the law; `None` if Abaqus and CalculiX have no such law."""

    @classmethod
    @abstractmethod
    def models(cls) -> Sequence[Model]:
        """Models by which the law is fitted, in the order of the list; empty if it cannot be fitted."""

    @property
    def constants(self) -> dict[str, float]:
        """Constants by name, MPa or pure numbers; those at their default are omitted."""
        values = {item.name: (getattr(self, item.name), item.default) for item in fields(self)}
        return {name: float(value) for name, (value, default) in values.items() if value != default}

    @classmethod
    def constants_text(cls) -> str:
        """Format of the constants, e.g. ``C10,C20,C30``."""
        return " or ".join(",".join(form) for form in cls._forms())

    @classmethod
    def from_numbers(cls, numbers: Sequence[float]) -> Self:
        """Make the law of its constants in the order of one of its forms.

        Raises
        ------
        PalpateError
            If it takes another count of constants.
        """
        form = next((form for form in cls._forms() if len(form) == len(numbers)), None)
        if form is None:
            raise PalpateError(
                f"{cls.name} takes {cls.constants_text()}, but {len(numbers)} numbers were given.",
                "Write them in MPa.",
                code="law-constant-count",
            )
        return cls.from_constants(dict(zip(form, numbers, strict=True)))

    @classmethod
    def from_constants(cls, constants: Mapping[str, float]) -> Self:
        """Make the law of its constants by name, as `constants` gives them.

        Raises
        ------
        PalpateError
            If its constants have other names, or one is missing.
        """
        known = {item.name for item in fields(cls)}
        needed = {item.name for item in fields(cls) if item.default is MISSING}
        if not constants or not needed <= set(constants) <= known:
            raise PalpateError(
                f"The constants of {cls.name} are not {', '.join(constants) or 'none'}.",
                f"They are {cls.constants_text()}.",
                code="law-constants-unknown",
            )
        make: Any = cls
        return make(**constants)

    @classmethod
    def _forms(cls) -> tuple[tuple[str, ...], ...]:
        return cls.forms or (tuple(item.name for item in fields(cls)),)


def refuse_stiffening(law: Law, stiffening: float) -> None:
    """Reject a variation of higher-order constants that a law does not have."""
    if not np.isclose(stiffening, 1.0):
        raise PalpateError(
            f"The law {law.name} has no constants of higher order to vary.",
            "Set the tolerance of stiffening to 0.",
            code="law-not-stiffening",
        )


class Model(ABC):
    """A family of laws with free constants, and the dependence of a test's stress on them.

    The nominal stress of an incompressible test is a sum of terms linear in some constants `c`; each term may depend
    on one more constant, its *shape*:

        P_1(lambda) = sum_k c_k phi_k(lambda; theta_k),   phi from P_1 = (tau_1 - tau_3) / lambda_1.

    Linear constants are solved exactly, and only the shapes are searched (variable projection, Golub & Pereyra 1973).
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """Name as on the command line, e.g. ``ogden-3``."""

    @property
    @abstractmethod
    def linear(self) -> tuple[str, ...]:
        """Names of the constants in which stress is linear, MPa."""

    @property
    @abstractmethod
    def shapes(self) -> tuple[str, ...]:
        """Names of the shapes, pure numbers: none, or one for each linear constant."""

    @abstractmethod
    def law(self, linear: FloatArray, shapes: FloatArray) -> Law:
        """Make the law of these constants, (k,) MPa and (k,) or (0,)."""

    @abstractmethod
    def terms(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        """Nominal stress (n, k) of each term at unit constant in principal stretches (n, 3)."""

    @abstractmethod
    def term_slopes(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        """Derivative (n, k) of each term by its shape; (n, 0) without shapes."""

    @abstractmethod
    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        """Bounds of the search for shapes, (2, k) each, and a start (k,) within them."""

    @abstractmethod
    def signs(self, shapes: FloatArray) -> FloatArray:
        """Signs (k,) of the linear constants for which a law of these shapes is stable; unused without shapes."""

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of all constants, linear ones first."""
        return self.linear + self.shapes
