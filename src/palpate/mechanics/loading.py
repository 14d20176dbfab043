"""What moves along a path: an obstacle that comes down on a body, or dead loads that grow."""

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
"""Travel in mm over which the power of an obstacle that does not only descend is taken."""
_FRICTIONLESS, _SLIPPING = 1.5, 0.8
"""Factors on the advance of the edge where contact remembers nothing, and where points slip while others stick."""


class PathLoading(ABC):
    """The terms that act on a body at a parameter of its path: depth in mm, or factor on its loads."""

    remembers: bool
    """Whether increments leave a history on which the next depend: friction."""

    @abstractmethod
    def start(self) -> ContactHistory:
        """History before anything acts."""

    @abstractmethod
    def max_increment(self, at: float, edge: float, radius: float) -> float:
        """Longest increment in mm from a depth in mm: the patch's edge advances by some `edge` mm in it.

        On a sphere of that radius in mm the patch has the radius ``sqrt(2 R d)``, so its edge goes `edge` on while
        the depth grows by ``edge sqrt(2 d / R)`` (docs/design_notes/mechanics.md). Infinite where nothing touches.
        """

    @abstractmethod
    def terms(self, at: float, history: ContactHistory) -> tuple[Term, ...]:
        """Terms at a parameter."""

    def power(self, at: float, state: State, history: ContactHistory, force: FloatArray, side: float) -> float:
        """Work of what moves over its parameter, mJ/mm, at a state and the force (3,) N on it.

        On the `side` of a greater (1) or lesser (-1) parameter, where the way may have a kink. Of what moves along
        one way it is the force along that.
        """
        return self.axial_force(force)

    def axial_force(self, force: FloatArray) -> float:
        """Share in N of a force (3,) N that acts against the way of what moves: along the axis."""
        return float(force[2])

    @abstractmethod
    def stuck_terms(self, at: float, last: float, state: State, history: ContactHistory) -> tuple[Term, ...]:
        """Terms at a parameter in which what touched in the `last` equilibrium cannot leave."""

    @abstractmethod
    def correct(
        self, history: ContactHistory, before: tuple[float, State], after: tuple[float, State]
    ) -> ContactHistory:
        """History corrected by a solution `after` the equilibrium `before`, each a parameter and a state."""

    @abstractmethod
    def update_history(self, history: ContactHistory, at: float, state: State) -> tuple[ContactHistory, float]:
        """History that an equilibrium leaves, and the work in mJ dissipated in the increment that led to it."""


@final
@dataclass(frozen=True)
class ContactLoading(PathLoading):
    """An obstacle that moves.

    Attributes
    ----------
    nodes
        (n, 3) mm of the body.
    surface
        Its outer surface.
    law
        Contact law.
    obstacle
        The obstacle at a depth in mm.
    aside
        Whether it moves other than along one way.
    way
        (3,) unit vector against which it moves; None: the axis.
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
        """Contact with the obstacle at a depth in mm, with this history."""
        obstacle = self.obstacle(at)
        return Contact(
            self.surface, self.law, obstacle, history._replace(anchor=obstacle.to_global_frame(history.anchor))
        )

    def power(self, at: float, state: State, history: ContactHistory, force: FloatArray, side: float) -> float:
        """See `PathLoading`; of one that goes aside too, by the energy of contact of a state that holds still."""
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
        """Contact points of a state and the obstacle at a depth in mm."""
        return ContactPair(self.surface.interpolate(self.nodes + state.u), self.obstacle(at))

    def penetration(self, at: float, state: State) -> FloatArray:
        """Penetration (n_points,) mm of a state into the obstacle at a depth in mm."""
        met = self.contact_pair(at, state)
        return met.obstacle.penetration(met.points)

    def touching(self, at: float, state: State) -> BoolArray:
        """Contact points (n_points,) of a state that touch the obstacle at a depth in mm."""
        return self.penetration(at, state) > 0


@final
@dataclass(frozen=True)
class DeadLoading(PathLoading):
    """Dead loads that grow in proportion.

    Attributes
    ----------
    load
        Forces at factor one.
    """

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
