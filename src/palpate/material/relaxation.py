"""Relaxation: share of the stress that remains some time after a strain, as a Prony series.

The law gives the stress of a strain; time enters by one function ``g`` that multiplies all of it (linear
viscoelasticity of a nonlinear law, Fung 1993, section 7.6; as a Prony series, Simo & Hughes 1998, section 10.3):

    tau(t) = ∫ g(t - s) d tau_e(s),   g(t) = 1 - sum_k g_k (1 - exp(-t / t_k))

so that ``g_k`` are shares of the instantaneous stress, as in Abaqus's ``*VISCOELASTIC, TIME=PRONY``. The volumetric
part does not relax.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from palpate.core import FloatArray, PalpateError

MOST_TERMS = 20
"""Maximum number of terms: two a decade over ten decades."""


class Moduli(StrEnum):
    """Time at which the constants of a law hold."""

    LONG_TERM = "long-term"
    INSTANTANEOUS = "instantaneous"


@dataclass(frozen=True)
class Relaxation:
    """A Prony series.

    Attributes
    ----------
    shares
        (k,) lost shares of the instantaneous stress; each at least 0, their sum below 1.
    times
        (k,) s, ascending.
    moduli
        Whether the law's constants are those after complete relaxation, as from a slow test, or the instantaneous
        ones.

    Examples
    --------
    >>> from palpate.material import Moduli, Relaxation
    >>> silicone = Relaxation((0.05, 0.1), (0.3, 20.0), Moduli.INSTANTANEOUS)
    >>> [round(float(part), 4) for part in silicone.relaxation_function([0.0, 1.0, 1e6])]
    [1.0, 0.9469, 0.85]
    """

    shares: tuple[float, ...]
    times: tuple[float, ...]
    moduli: Moduli = Moduli.LONG_TERM

    def __post_init__(self) -> None:
        if len(self.shares) != len(self.times) or not 1 <= len(self.times) <= MOST_TERMS:
            raise PalpateError(
                f"A relaxation has {len(self.shares)} shares and {len(self.times)} times.",
                f"Give as many of each, 1 to {MOST_TERMS}.",
                code="relaxation-lengths-differ",
            )
        for number, (share, time) in enumerate(zip(self.shares, self.times, strict=True), start=1):
            if not share >= 0:
                raise PalpateError(
                    f"Share {number} of the relaxation is {share:g}.",
                    "Give a share of 0 or more.",
                    code="relaxation-share-negative",
                )
            if not 0 < time < np.inf:
                raise PalpateError(
                    f"Time {number} of the relaxation is {time:g} s.",
                    "Give a time above 0 s.",
                    code="relaxation-time-not-positive",
                )
        if not sum(self.shares) < 1:
            raise PalpateError(
                f"The shares of the relaxation sum to {sum(self.shares):.6g}.",
                "Their sum is below 1: something of the stress of a solid is left in the end.",
                code="relaxation-shares-sum",
            )
        if any(later <= sooner for sooner, later in zip(self.times, self.times[1:], strict=False)):
            raise PalpateError(
                f"The times of the relaxation are {', '.join(f'{time:g}' for time in self.times)} s.",
                "Write the terms by ascending time, each time once.",
                code="relaxation-times-not-rising",
            )

    @property
    def long_term_share(self) -> float:
        """Share of the instantaneous stress that remains after complete relaxation."""
        return 1.0 - sum(self.shares)

    @property
    def scale(self) -> float:
        """Instantaneous modulus over that of the law's constants."""
        return 1.0 if self.moduli is Moduli.INSTANTANEOUS else 1.0 / self.long_term_share

    def relaxation_function(self, time: FloatArray | Sequence[float] | float) -> FloatArray:
        """Remaining share ``g`` (n,) of the instantaneous stress at times (n,) s after a step of strain."""
        passed = np.asarray(time, float)[..., None] / np.array(self.times)
        return np.asarray(1.0 + np.expm1(-passed) @ np.array(self.shares))

    def modulus(self, time: FloatArray | Sequence[float] | float) -> FloatArray:
        """Modulus (n,) over that of the law's constants, at times (n,) s since a step of strain."""
        return self.scale * self.relaxation_function(time)

    def key_data(self) -> dict[str, Any]:
        """Return the identity as plain values: moduli, shares, times (s)."""
        return {"moduli": str(self.moduli), "shares": list(self.shares), "times": list(self.times)}

    @classmethod
    def from_data(cls, data: dict[str, Any]) -> Relaxation:
        """Build a relaxation from its `key_data`."""
        return cls(tuple(data["shares"]), tuple(data["times"]), Moduli(data["moduli"]))
