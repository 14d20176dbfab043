"""Models that several laws share: linear in all constants, or a modulus and one shape of the chains."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, fields
from typing import ClassVar, final

import numpy as np

from palpate.core import FloatArray
from palpate.material.law import Law, Model
from palpate.material.laws.invariants import drive


@final
@dataclass(frozen=True)
class LinearModel(Model):
    """A law whose stress is linear in its constants; its terms are the law with one constant at 1 MPa.

    Attributes
    ----------
    label
        Its name.
    form
        The law.
    free
        Names of the fitted constants; the remaining ones have their defaults.
    """

    label: str
    form: type[Law]
    free: tuple[str, ...]

    @property
    def name(self) -> str:
        return self.label

    @property
    def linear(self) -> tuple[str, ...]:
        return self.free

    @property
    def shapes(self) -> tuple[str, ...]:
        return ()

    def law(self, linear: FloatArray, shapes: FloatArray) -> Law:
        return self.form.from_constants(dict(zip(self.free, map(float, linear), strict=True)))

    def terms(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        F = np.ascontiguousarray(principal[:, :, None] * np.eye(3))
        stresses = [self.law(unit, shapes).isochoric(F)[1] for unit in np.eye(len(self.free))]
        return np.column_stack([(tau[:, 0] - tau[:, 2]) / principal[:, 0] for tau in stresses])

    def term_slopes(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        return np.empty((len(principal), 0))

    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        return [(np.empty((2, 0)), np.empty(0))]

    def signs(self, shapes: FloatArray) -> FloatArray:
        return np.ones(len(self.free))


class ChainModel(Model):
    """A function of I1 alone: linear in the modulus mu, with one shape, stable where mu is positive.

    Attributes
    ----------
    form
        The law, whose two fields are mu and the shape.
    """

    form: ClassVar[type[Law]]

    @property
    def name(self) -> str:
        return self.form.name

    @property
    def shapes(self) -> tuple[str, ...]:
        return (fields(self.form)[1].name,)

    def law(self, linear: FloatArray, shapes: FloatArray) -> Law:
        return self.form.from_numbers([float(linear[0]), float(shapes[0])])

    @abstractmethod
    def slope(self, principal: FloatArray, shape: float) -> tuple[FloatArray, FloatArray]:
        """``W1 / mu`` and its derivative by the shape, (n,) each, in principal stretches (n, 3)."""

    @property
    def linear(self) -> tuple[str, ...]:
        return ("mu",)

    def terms(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        return np.asarray(drive(principal) * self.slope(principal, shapes[0])[0])[:, None]

    def term_slopes(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        return np.asarray(drive(principal) * self.slope(principal, shapes[0])[1])[:, None]

    def signs(self, shapes: FloatArray) -> FloatArray:
        return np.ones(1)
