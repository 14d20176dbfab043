"""One accepted equilibrium of a path."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.mechanics.friction import ContactHistory
from palpate.mechanics.newton import Loads
from palpate.mechanics.solid import State


@dataclass(frozen=True)
class Increment:
    """One accepted equilibrium of the modelled part.

    Attributes
    ----------
    depth
        Parameter of the path: depth of the obstacle in mm, or factor on dead loads.
    state, loads, history
        Displacement and pressure; energies and force; contact history.
    jumped
        Whether it was reached by a jump.
    negative_pivots
        Unstable modes of the equilibrium; -1 if the linear solver does not compute them.
    tension
        MPa, maximum tension of the springs that stabilise contact.
    dissipated
        mJ, work of friction from the start of the path.
    power
        mJ/mm, derivative of the work by the parameter.
    """

    depth: float
    state: State
    loads: Loads
    history: ContactHistory
    jumped: bool = False
    negative_pivots: int = 0
    tension: float = 0.0
    dissipated: float = 0.0
    power: float = 0.0
