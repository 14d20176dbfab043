"""Models a curve is fitted by: each says which constants it has and how the stress of a test depends on them.

In every model here the nominal stress of an incompressible test is a sum of terms linear in some constants `c`; each
term may hang on one more constant, its *shape*:

    P_1(lambda) = sum_k c_k phi_k(lambda; theta_k),   phi from P_1 = (tau_1 - tau_3) / lambda_1.

So a polynomial is fitted exactly, and the others by a search over the shapes alone (variable projection, Golub &
Pereyra 1973).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from palpate.core import PalpateError
from palpate.material.law import (
    MOONEY_RIVLIN,
    FloatArray,
    Law,
    Polynomial,
    mooney_rivlin,
    neo_hooke,
    ogden,
    yeoh,
)
from palpate.material.locking import CHAIN, arruda_boyce, gent


class Model(ABC):
    """A family of laws with free constants."""

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
        """Names of the others, pure numbers: none, or one for each linear constant."""

    @abstractmethod
    def law(self, linear: FloatArray, shapes: FloatArray) -> Law:
        """Make the law of these constants, (k,) MPa and (k,) or (0,)."""

    @abstractmethod
    def terms(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        """Nominal stress (n, k) of each term at unit constant in principal stretches (n, 3)."""

    @abstractmethod
    def term_slopes(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        """Derivative (n, k) of each term by its shape; (n, 0) where there is none."""

    @abstractmethod
    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        """Boxes to search for shapes in, (2, k) each, and a start (k,) within it."""

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of all constants, linear ones first."""
        return self.linear + self.shapes


@dataclass(frozen=True)
class PolynomialModel(Model):
    """A polynomial law: linear in all its constants.

    Attributes
    ----------
    label
        Its name.
    coefficients
        Its coefficients, as `Polynomial` calls them.
    make
        The law from their values.
    """

    label: str
    coefficients: tuple[str, ...]
    make: Callable[..., Polynomial]

    @property
    def name(self) -> str:
        return self.label

    @property
    def linear(self) -> tuple[str, ...]:
        return tuple(name.upper() for name in self.coefficients)

    @property
    def shapes(self) -> tuple[str, ...]:
        return ()

    def law(self, linear: FloatArray, shapes: FloatArray) -> Law:
        return self.make(*(float(value) for value in linear))

    def terms(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        """``P_1 = 2 (l1 - l3²/l1) (W1 + l2² W2)``."""
        x, y = _invariants(principal)
        one, zero = np.ones_like(x), np.zeros_like(x)
        slopes = {
            "c10": (one, zero),
            "c01": (zero, one),
            "c20": (2 * x, zero),
            "c11": (y, x),
            "c02": (zero, 2 * y),
            "c30": (3 * x**2, zero),
        }
        middle = principal[:, 1] ** 2
        columns = [slopes[name][0] + middle * slopes[name][1] for name in self.coefficients]
        return _drive(principal)[:, None] * np.column_stack(columns)

    def term_slopes(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        return np.empty((len(principal), 0))

    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        return [(np.empty((2, 0)), np.empty(0))]


@dataclass(frozen=True)
class OgdenModel(Model):
    """Ogden's law of one to three terms: linear in its moduli."""

    count: int

    @property
    def name(self) -> str:
        return f"ogden-{self.count}"

    @property
    def linear(self) -> tuple[str, ...]:
        return tuple(f"mu{k + 1}" for k in range(self.count))

    @property
    def shapes(self) -> tuple[str, ...]:
        return tuple(f"alpha{k + 1}" for k in range(self.count))

    def law(self, linear: FloatArray, shapes: FloatArray) -> Law:
        return ogden(*(float(value) for pair in zip(linear, shapes, strict=True) for value in pair))

    def terms(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        first, third = principal[:, :1], principal[:, 2:]
        return np.asarray((first**shapes - third**shapes) / first)

    def term_slopes(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        first, third = principal[:, :1], principal[:, 2:]
        return np.asarray((first**shapes * np.log(first) - third**shapes * np.log(third)) / first)

    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        """One box for each choice of signs, and in each a start from small exponents to large ones.

        Planar tension cannot tell a term from that with both constants negated. The positive exponent is taken: at
        the same I1 it asks for far less stress in the other modes.
        """
        ladders = (1.3, 2.0, 4.0, 8.0, 0.4 * largest_exponent)
        found = []
        planar = np.allclose(principal[:, 1], 1.0)
        for negative in range(1 if planar else self.count + 1):
            sign = np.where(np.arange(self.count) < self.count - negative, 1.0, -1.0)
            box = np.sort(np.stack([0.05 * sign, largest_exponent * sign]), axis=0)
            for steps in product(range(len(ladders)), repeat=self.count):
                if sum(steps) <= 2 * self.count and _grow_within_signs(steps, sign):
                    rungs = np.array([ladders[step] for step in steps])
                    found.append((box, np.minimum(rungs, largest_exponent) * sign))
        return found


@dataclass(frozen=True)
class LockingModel(Model):
    """Gent or Arruda–Boyce: linear in the modulus, with one locking stretch.

    Attributes
    ----------
    label, shape
        Names of the model and of its shape.
    make
        The law from modulus and shape.
    """

    label: str
    shape: str
    make: Callable[[float, float], Law]

    @property
    def name(self) -> str:
        return self.label

    @property
    def linear(self) -> tuple[str, ...]:
        return ("mu",)

    @property
    def shapes(self) -> tuple[str, ...]:
        return (self.shape,)

    def law(self, linear: FloatArray, shapes: FloatArray) -> Law:
        return self.make(float(linear[0]), float(shapes[0]))

    def terms(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        return np.asarray(_drive(principal) * self._slope(principal, shapes[0])[0])[:, None]

    def term_slopes(self, principal: FloatArray, shapes: FloatArray) -> FloatArray:
        return np.asarray(_drive(principal) * self._slope(principal, shapes[0])[1])[:, None]

    def starts(self, principal: FloatArray, largest_exponent: float) -> list[tuple[FloatArray, FloatArray]]:
        greatest = _invariants(principal)[0].max()
        if self.shape == "Jm":
            box = np.array([[greatest * (1 + 1e-6)], [1e5 * greatest + 1]])
            return [(box, np.array([greatest * factor])) for factor in (1.02, 1.3, 3.0, 20.0)]
        box = np.array([[0.2], [1e3]])
        return [(box, np.array([np.sqrt(greatest / 3 + 1) * factor])) for factor in (0.6, 1.0, 2.0, 6.0)]

    def _slope(self, principal: FloatArray, shape: float) -> tuple[FloatArray, FloatArray]:
        """``W1 / mu`` and its derivative by the shape, (n,) each."""
        x = _invariants(principal)[0]
        if self.shape == "Jm":
            left = 1 - x / shape
            return 0.5 / left, -0.5 * x / (left * shape) ** 2
        order = np.arange(1, len(CHAIN) + 1)
        each = np.array(CHAIN) * order * (x[:, None] + 3) ** (order - 1) * shape ** (2.0 - 2 * order)
        return each.sum(axis=1), np.asarray((each * (2 - 2 * order)).sum(axis=1) / shape)


def _invariants(principal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """``I1 - 3`` and ``I2 - 3``, (n,) each."""
    square = principal**2
    return square.sum(axis=1) - 3, (1 / square).sum(axis=1) - 3


def _drive(principal: FloatArray) -> FloatArray:
    """``2 (l1 - l3²/l1)`` (n,)."""
    return np.asarray(2 * (principal[:, 0] - principal[:, 2] ** 2 / principal[:, 0]))


def _grow_within_signs(steps: tuple[int, ...], sign: FloatArray) -> bool:
    """Whether exponents of one sign grow: every set of them is then written once."""
    pairs = zip(range(len(steps) - 1), range(1, len(steps)), strict=True)
    return all(sign[a] != sign[b] or steps[a] < steps[b] for a, b in pairs)


MODELS: dict[str, Model] = {
    model.name: model
    for model in (
        PolynomialModel("neo-hooke", ("c10",), neo_hooke),
        PolynomialModel("mooney-rivlin", MOONEY_RIVLIN[2], mooney_rivlin),
        PolynomialModel("mooney-rivlin-3", MOONEY_RIVLIN[3], mooney_rivlin),
        PolynomialModel("mooney-rivlin-5", MOONEY_RIVLIN[5], mooney_rivlin),
        PolynomialModel("yeoh", ("c10", "c20", "c30"), yeoh),
        LockingModel("gent", "Jm", gent),
        OgdenModel(1),
        OgdenModel(2),
        OgdenModel(3),
        LockingModel("arruda-boyce", "lm", arruda_boyce),
    )
}
"""Models by name."""


SECOND_INVARIANT = PolynomialModel(
    "yeoh-i2",
    ("c10", "c01", "c20", "c30"),
    lambda c10, c01, c20, c30: Polynomial("yeoh-i2", c10=c10, c01=c01, c20=c20, c30=c30),
)
"""Yeoh's law with a term in I2: no choice of a person's, but a witness of what I2 could do where it was not seen."""


def get_model(name: str) -> Model:
    """Get a model by its name.

    Raises
    ------
    PalpateError
        If there is none of that name.
    """
    if name == SECOND_INVARIANT.name:
        return SECOND_INVARIANT
    if name not in MODELS:
        raise PalpateError(f"There is no model '{name}'.", f"Choose one of {', '.join(MODELS)}.")
    return MODELS[name]
