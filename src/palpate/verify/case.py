"""A case of the verification suite, and one row of its table: ours against a reference within a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Row:
    """One quantity of a case, where it deviates most.

    Attributes
    ----------
    quantity
        What is compared, with its unit.
    at
        Where along the reference the deviation is greatest; empty where there is one value.
    ours, reference
        The two values there.
    deviation
        Their distance over `scale`: relative to the reference, or to what the quantity says.
    tolerance
        Greatest deviation that passes.
    count
        Values compared.
    """

    quantity: str
    at: str
    ours: float
    reference: float
    deviation: float
    tolerance: float
    count: int = 1

    @property
    def passed(self) -> bool:
        """Whether the deviation is within the tolerance (a deviation that is no number is not)."""
        return self.deviation <= self.tolerance


@dataclass(frozen=True)
class Case:
    """A problem with a known answer.

    Attributes
    ----------
    name
        Short name, as on the command line.
    reference
        Where the answer comes from.
    run
        Solves the problem by the package and compares.
    slow
        Whether it takes more than some ten seconds; left out by a quick run.
    """

    name: str
    reference: str
    run: Callable[[], Sequence[Row]]
    slow: bool = False


def compare(
    quantity: str,
    ours: ArrayLike,
    reference: ArrayLike,
    tolerance: float,
    at: Sequence[str] = (),
    scale: ArrayLike | None = None,
) -> Row:
    """Compare values and keep the one that deviates most.

    Parameters
    ----------
    quantity
        What they are, with the unit.
    ours, reference
        (n,) values or one; two that are both nan agree.
    tolerance
        Greatest deviation that passes.
    at
        (n,) where each value stands.
    scale
        (n,) or one: what deviations are measured by; the magnitude of the reference where it is not given.
    """
    here, there = np.atleast_1d(np.asarray(ours, float)), np.atleast_1d(np.asarray(reference, float))
    measure = np.abs(there) if scale is None else np.broadcast_to(np.asarray(scale, float), there.shape)
    agree = (here == there) | (np.isnan(here) & np.isnan(there))
    distance = np.where(agree, 0.0, np.abs(here - there))
    with np.errstate(divide="ignore", invalid="ignore"):
        deviation = np.where(agree, 0.0, distance / measure)
    deviation[np.isnan(deviation)] = np.inf
    worst = int(np.argmax(deviation))
    return Row(
        quantity=quantity,
        at=at[worst] if len(at) else "",
        ours=float(here[worst]),
        reference=float(there[worst]),
        deviation=float(deviation[worst]),
        tolerance=tolerance,
        count=len(there),
    )


def below(quantity: str, value: float, tolerance: float) -> Row:
    """Compare a value with zero: an error, residual or deviation that must not exceed the tolerance."""
    return compare(quantity, value, 0.0, tolerance, scale=1.0)
