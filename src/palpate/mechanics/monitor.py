"""Interface of a monitor of a path: branch of a state, contact stabilisation, and end criteria."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import StrEnum
from typing import final

from palpate.core import FloatArray
from palpate.mechanics.solid import State


class EndReason(StrEnum):
    """Reason why a press ended."""

    DEPTH_REACHED = "depth reached"
    WALL_AT_CLAMP = "wall reached the clamped rim"
    BRANCH_ENDED = "the branch ended"
    NO_BRANCH = "no inverted state"
    FOLDED = "the squeezed silicone folded"
    NOT_CONVERGED = "not converged"


class Monitor(ABC):
    """Monitor of the equilibria of a path.

    Attributes
    ----------
    modulus
        Young's modulus in MPa, the scale of the tension that may stabilise contact.
    area
        Area of the surface in mm², the scale of the viscosity of a jump.
    """

    modulus: float
    area: float

    @abstractmethod
    def inverted(self, at: float, state: State) -> bool:
        """Test whether a state belongs to the inverted branch at a depth in mm."""

    @abstractmethod
    def stabilisation(self, at: float, state: State) -> FloatArray | None:
        """Return springs (n_points,) MPa/mm that stabilise contact from here on; None leaves them unchanged."""

    @abstractmethod
    def tension(self, at: float, state: State, springs: FloatArray) -> float:
        """Return the maximum tension in MPa of the springs (n_points,) MPa/mm."""

    @abstractmethod
    def perturbed(self, at: float, state: State, push: float) -> FloatArray:
        """Return the displacement (n, 3) mm of a state pushed by so many mm towards the second branch."""

    @abstractmethod
    def fault(self, state: State) -> tuple[EndReason, str] | None:
        """Return the reason why states after this one are not modelled, or None."""


@final
@dataclass(frozen=True)
class NullMonitor(Monitor):
    """Monitor of a path of one branch, without stabilisation."""

    modulus: float = 1.0
    area: float = 1.0

    def inverted(self, at: float, state: State) -> bool:
        return False

    def stabilisation(self, at: float, state: State) -> FloatArray | None:
        return None

    def tension(self, at: float, state: State, springs: FloatArray) -> float:
        return 0.0

    def perturbed(self, at: float, state: State, push: float) -> FloatArray:
        return state.u

    def fault(self, state: State) -> tuple[EndReason, str] | None:
        return None
