"""Loading of a path: an obstacle that moves against a body, or increasing dead loads."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.mechanics.contact import Contact
from palpate.mechanics.friction import (
    ContactHistory,
    ContactLaw,
    ContactPair,
    correct_history,
    dissipated,
    empty_history,
    return_to_limit,
)
from palpate.mechanics.obstacle import Obstacle
from palpate.mechanics.solid import State
from palpate.mechanics.surface import OuterSurface
from palpate.mechanics.term import DeadLoad, Term

_TINY = 1e-7
"""Step in mm for the power of an obstacle that also moves laterally. By hand."""
_FRICTIONLESS, _SLIPPING = 1.5, 0.8
"""Factors on the advance of the edge without contact memory, and if points slip while others stick.
The second at half or twice: 2 % of force. By hand."""


class PathLoading(ABC):
    """The terms that act on a body at a parameter of its path: depth in mm, or factor on its loads."""

    remembers: bool
    """Whether increments leave a history on which later ones depend: friction."""

    @abstractmethod
    def start(self) -> ContactHistory:
        """Return the history at the start."""

    @abstractmethod
    def max_increment(self, at: float, edge: float, radius: float) -> float:
        """Return the maximum increment in mm from a depth in mm: the patch's edge advances by about `edge` mm.

        On a sphere of that radius in mm the patch has the radius ``sqrt(2 R d)``, so its edge advances by `edge`
        while the depth grows by ``edge sqrt(2 d / R)`` (docs/design_notes/mechanics.md). Infinite without contact.
        """

    @abstractmethod
    def terms(self, at: float, history: ContactHistory) -> tuple[Term, ...]:
        """Return the terms at a parameter."""

    def power(self, at: float, state: State, history: ContactHistory, force: FloatArray, side: float) -> float:
        """Return the derivative of the work by the parameter, mJ/mm, at a state and a force (3,) N.

        It is one-sided, towards a larger (`side` 1) or smaller (-1) parameter, since the path may have a kink. For
        motion along one line it is the force along that line.
        """
        return self.axial_force(force)

    def axial_force(self, force: FloatArray) -> float:
        """Return the component in N of a force (3,) N against the motion: along the axis."""
        return float(force[2])

    @abstractmethod
    def stuck_terms(self, at: float, last: float, state: State, history: ContactHistory) -> tuple[Term, ...]:
        """Return terms at a parameter in which points in contact in the `last` equilibrium cannot separate."""

    @abstractmethod
    def correct(
        self, history: ContactHistory, before: tuple[float, State], after: tuple[float, State]
    ) -> ContactHistory:
        """Correct the history by a solution `after` the equilibrium `before`, each a parameter and a state."""

    @abstractmethod
    def update_history(self, history: ContactHistory, at: float, state: State) -> tuple[ContactHistory, float]:
        """Return the history after an equilibrium, and the work in mJ dissipated in the increment before it."""


@final
@dataclass(frozen=True)
class ContactLoading(PathLoading):
    """An obstacle that moves.

    Attributes
    ----------
    nodes, surface
        (n, 3) mm nodes of the body, and its outer surface.
    law
        Contact law.
    obstacle
        The obstacle at a depth in mm.
    aside
        Whether its motion is not along one line.
    way
        (3,) unit vector opposite to its motion; None: the axis.
    """

    nodes: FloatArray
    surface: OuterSurface
    law: ContactLaw
    obstacle: Callable[[float], Obstacle]
    aside: bool = False
    way: FloatArray | None = None

    @property
    def remembers(self) -> bool:  # type: ignore[override]
        return self.law.friction > 0

    def max_increment(self, at: float, edge: float, radius: float) -> float:
        share = 1.0 if np.isinf(self.law.friction) else _SLIPPING if self.remembers else _FRICTIONLESS
        return float(share * edge * np.sqrt(2.0 * at / radius))

    def start(self) -> ContactHistory:
        return empty_history(len(self.surface.points))

    def terms(self, at: float, history: ContactHistory) -> tuple[Term, ...]:
        return (self.contact(at, history),)

    def contact(self, at: float, history: ContactHistory) -> Contact:
        """Return the contact with the obstacle at a depth in mm, with this history."""
        obstacle = self.obstacle(at)
        return Contact(
            self.surface, self.law, obstacle, history._replace(anchor=obstacle.to_global_frame(history.anchor))
        )

    def power(self, at: float, state: State, history: ContactHistory, force: FloatArray, side: float) -> float:
        """Return the power as in `PathLoading`; by the contact energy of a fixed state if it moves laterally."""
        if not self.aside:
            return super().power(at, state, history, force, side)
        there, here = (self.contact(at + step, history).energy(state, self.nodes) for step in (side * _TINY, 0.0))
        return (there - here) / (side * _TINY)

    def axial_force(self, force: FloatArray) -> float:
        return super().axial_force(force) if self.way is None else float(force @ self.way)

    def stuck_terms(self, at: float, last: float, state: State, history: ContactHistory) -> tuple[Term, ...]:
        pull = np.where(self.touching(last, state), self.law.stiffness, history.stabilisation)
        return self.terms(at, history._replace(stabilisation=pull))

    def correct(
        self, history: ContactHistory, before: tuple[float, State], after: tuple[float, State]
    ) -> ContactHistory:
        area = self.surface.faces.weight.ravel()
        return correct_history(self.law, history, self.contact_pair(*before), self.contact_pair(*after), area)

    def update_history(self, history: ContactHistory, at: float, state: State) -> tuple[ContactHistory, float]:
        met = self.contact_pair(at, state)
        lost = dissipated(self.law, history, met, self.surface.faces.weight.ravel())
        return return_to_limit(self.law, history, met), lost

    def contact_pair(self, at: float, state: State) -> ContactPair:
        """Return the contact points of a state and the obstacle at a depth in mm."""
        return ContactPair(self.surface.interpolate(self.nodes + state.u), self.obstacle(at))

    def penetration(self, at: float, state: State) -> FloatArray:
        """Return the penetration (n_points,) mm of a state into the obstacle at a depth in mm."""
        met = self.contact_pair(at, state)
        return met.obstacle.penetration(met.points)

    def touching(self, at: float, state: State) -> BoolArray:
        """Test which contact points (n_points,) of a state touch the obstacle at a depth in mm."""
        return self.penetration(at, state) > 0


@final
@dataclass(frozen=True)
class DeadLoading(PathLoading):
    """Dead loads that grow in proportion; `load` has the forces at factor one."""

    load: DeadLoad
    remembers = False

    def max_increment(self, at: float, edge: float, radius: float) -> float:
        return np.inf

    def start(self) -> ContactHistory:
        return empty_history(0)

    def terms(self, at: float, history: ContactHistory) -> tuple[Term, ...]:
        return (replace(self.load, factor=at),)

    def stuck_terms(self, at: float, last: float, state: State, history: ContactHistory) -> tuple[Term, ...]:
        return self.terms(at, history)

    def correct(
        self, history: ContactHistory, before: tuple[float, State], after: tuple[float, State]
    ) -> ContactHistory:
        return history

    def update_history(self, history: ContactHistory, at: float, state: State) -> tuple[ContactHistory, float]:
        return history, 0.0
