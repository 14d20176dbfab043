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
        Parameter of the path: mm travel of the obstacle, or factor on dead loads.
    state
        Displacement and pressure.
    loads
        Energies and force.
    history
        What the contact points remember.
    jumped
        Whether a jump led here.
    negative_pivots
        Unstable modes of the equilibrium; -1 where the linear solver cannot tell.
    tension
        MPa, greatest tension of the springs that stabilise contact.
    dissipated
        mJ of friction from the start of the path.
    power
        mJ/mm, work of what moves over the parameter.
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
