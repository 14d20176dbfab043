"""Case of the verification suite, and row of its table: result, reference and tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Row:
    """One quantity of a case, at its maximum deviation.

    Attributes
    ----------
    quantity
        Compared quantity, with its unit.
    at
        Place of the maximum deviation along the reference; empty for a single value.
    ours, reference
        The two values there.
    deviation
        Their distance over `scale`: relative to the reference, or to the scale that the quantity states.
    tolerance
        Maximum deviation that passes.
    count
        Number of values compared.
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
        """Whether the deviation is within the tolerance; a deviation of NaN is not."""
        return self.deviation <= self.tolerance


@dataclass(frozen=True)
class Case:
    """A problem of known solution.

    Attributes
    ----------
    name
        Short name, as on the command line.
    reference
        Source of the solution.
    run
        Solves the problem by palpate and compares.
    """

    name: str
    reference: str
    run: Callable[[], Sequence[Row]]


def compare(
    quantity: str,
    ours: ArrayLike,
    reference: ArrayLike,
    tolerance: float,
    at: Sequence[str] = (),
    scale: ArrayLike | None = None,
) -> Row:
    """Compare values and return the row of the maximum deviation.

    Parameters
    ----------
    quantity
        Compared quantity, with its unit.
    ours, reference
        (n,) values or one; two that are both nan agree.
    tolerance
        Maximum deviation that passes.
    at
        (n,) labels of the values.
    scale
        (n,) or one: scale of the deviations; by default the magnitude of the reference.
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
