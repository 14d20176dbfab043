"""Terms of the energy in addition to the solid's: contact, loads, damping.

Newton's method minimises the sum.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from palpate.core import FloatArray, IntArray
from palpate.mechanics.element import System
from palpate.mechanics.solid import State


class TermContribution(NamedTuple):
    """Contribution of a term: energy, mJ, and force (3,) N on the obstacle."""

    energy: float
    force: FloatArray


class Assembly(NamedTuple):
    """The linear system to which terms are added.

    Attributes
    ----------
    nodes
        (n, 3) mm, undeformed.
    free
        (n_free,) numbers of the free ones of the 3 n degrees of freedom.
    place
        (n_cells, 3321) index of every entry of a cell (see `palpate.mechanics.element.Cells`).
    diagonal
        (n_free,) indices of the diagonal.
    volume
        (n,) mm³ of the nodes.
    system
        Values of the matrix and residual.
    """

    nodes: FloatArray
    free: IntArray
    place: IntArray
    diagonal: IntArray
    volume: FloatArray
    system: System


class Term(ABC):
    """One summand of the energy."""

    @abstractmethod
    def assemble(self, state: State, to: Assembly) -> TermContribution:
        """Add the first derivative of the energy to the residual and the second to the upper triangle."""


@final
@dataclass(frozen=True)
class DeadLoad(Term):
    """Forces of constant direction: energy ``-k f·u`` with forces f (n, 3) N at the nodes and a factor k.

    The derivative of the energy by the factor, ``-f·u`` in mJ, is returned as the force of an obstacle along z.
    """

    force: FloatArray
    factor: float = 1.0

    def assemble(self, state: State, to: Assembly) -> TermContribution:
        to.system.residual[:] -= self.factor * self.force.ravel()
        way = float((self.force * state.u).sum())
        return TermContribution(-self.factor * way, np.array([0.0, 0.0, -way]))


@final
@dataclass(frozen=True)
class Damping(Term):
    """Viscosity of a pseudo-time step, ``c/2 |u - u0|²`` weighted by nodal volume; energy not counted.

    `coefficient` is c, MPa/mm², and `origin` (n, 3) mm is u0.
    """

    coefficient: float
    origin: FloatArray

    def assemble(self, state: State, to: Assembly) -> TermContribution:
        viscous = self.coefficient * np.repeat(to.volume, 3)
        to.system.residual[:] += viscous * (state.u - self.origin).ravel()
        to.system.data[to.diagonal] += viscous[to.free]
        return TermContribution(0.0, np.zeros(3))
