"""Force and depth through time of an obstacle that comes down and stays, from the force of one press.

A press knows the force at every depth of an elastic skin. Where the depth follows a course, the shape of the skin at
every time is that of the press, since one function relaxes all stresses alike, and its force is the elastic one
relaxed. Where the robot gives way, or holds its force, the depth is part of what is sought: one equation a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from palpate.core import FloatArray, PalpateError
from palpate.material.relaxation import Relaxation
from palpate.material.relaxation_history import StressHistory, relax_history


@dataclass(frozen=True, eq=False)
class ForceCurve:
    """Force over depth of an elastic press, straight between its increments.

    Attributes
    ----------
    depth
        (n,) mm, rising from 0.
    force
        (n,) N along the wall's normal, or (n, 3) N.

    Raises
    ------
    PalpateError
        If the depths do not rise, as those of a press that is drawn back, or there are not as many forces.
    """

    depth: FloatArray
    force: FloatArray

    def __post_init__(self) -> None:
        if len(self.depth) != len(self.force) or not (np.diff(self.depth) > 0).all():
            raise PalpateError(
                f"{len(self.depth)} depths and {len(self.force)} forces are no curve of a press on its way down.",
                "Give rising depths and a force for each; of a press that was drawn back, the way down.",
                code="press-curve-malformed",
            )

    def at(self, depth: FloatArray) -> FloatArray:
        """Force (m,) or (m, 3) N at depths (m,) mm.

        Raises
        ------
        PalpateError
            If a depth is beyond the press.
        """
        deepest = float(np.max(depth, initial=0.0))
        if deepest > self.depth[-1] * (1 + 1e-9):
            raise PalpateError(
                f"The wall goes to {deepest:.4g} mm and was pressed to {self.depth[-1]:.4g} mm.",
                "Press deeper, or command less depth.",
                code="press-curve-too-short",
            )
        if self.force.ndim == 1:
            return np.interp(depth, self.depth, self.force)
        return np.column_stack([np.interp(depth, self.depth, part) for part in self.force.T])


class WallHistory(NamedTuple):
    """A wall through time.

    Attributes
    ----------
    time
        (n,) s.
    depth
        (n,) mm.
    force
        (n,) or (n, 3) N.
    """

    time: FloatArray
    depth: FloatArray
    force: FloatArray


def simulate_depth_hold(
    relaxation: Relaxation, curve: ForceCurve, time: FloatArray, depth: FloatArray
) -> WallHistory:
    """Follow a wall whose depth is known, as on a stiff robot.

    Parameters
    ----------
    relaxation
        Of the skin.
    curve
        Of the elastic press.
    time
        (n,) s, not falling.
    depth
        (n,) mm, straight between the times; the first is reached at once.

    Returns
    -------
    WallHistory
        At these times; exact for this curve.
    """
    course = _course(time, depth)
    pieces = [course[:1]]
    for start, end in pairwise(course):
        share = _passed(curve, start[1], end[1])[:, None]
        pieces.append(np.vstack([start + share * (end - start), end]))
    cut = np.concatenate(pieces)
    force = relax_history(relaxation, cut[:, 0], curve.at(cut[:, 1]))
    return WallHistory(course[:, 0], course[:, 1], force[np.cumsum([len(piece) for piece in pieces]) - 1])


def simulate_compliant_hold(
    relaxation: Relaxation, curve: ForceCurve, time: FloatArray, travel: FloatArray, stiffness: float
) -> WallHistory:
    """Follow a wall on a robot that gives way: it sinks in as the force fades.

    At every time, ``stiffness · (travel - depth)`` is the force.

    Parameters
    ----------
    relaxation
        Of the skin.
    curve
        Of the elastic press, force along the wall's normal.
    time
        (n,) s, rising; between them the elastic force is taken to run straight, so give them densely.
    travel
        (n,) mm that the robot is commanded, as if it were stiff.
    stiffness
        Of the robot along its travel, N/mm.

    Returns
    -------
    WallHistory
        At these times.

    Raises
    ------
    PalpateError
        If the stiffness is not positive, or the wall goes beyond the press.
    """
    if not 0 < stiffness < np.inf:
        raise PalpateError(
            f"The robot's stiffness is {stiffness:g} N/mm.", "Give one above 0.", code="robot-stiffness-not-positive"
        )
    course = _course(time, travel)
    return _balance(relaxation, curve, course * [1.0, stiffness], stiffness)


def simulate_force_hold(
    relaxation: Relaxation, curve: ForceCurve, time: FloatArray, force: FloatArray
) -> WallHistory:
    """Follow a wall on which a robot keeps a force: it creeps in.

    Parameters
    ----------
    relaxation, curve, time
        As for `simulate_compliant_hold`.
    force
        (n,) N along the wall's normal.

    Returns
    -------
    WallHistory
        At these times.

    Raises
    ------
    PalpateError
        If the wall goes beyond the press.
    """
    return _balance(relaxation, curve, _course(time, force), 0.0)


def _course(time: FloatArray, given: FloatArray) -> FloatArray:
    """Times and what is given at each, (n, 2)."""
    time, given = np.asarray(time, float), np.asarray(given, float)
    if time.ndim != 1 or time.shape != given.shape:
        raise PalpateError(
            f"There are {time.size} times and {given.size} values.",
            "Give one value for every time.",
            code="course-lengths-differ",
        )
    return np.column_stack([time, given])


def _balance(relaxation: Relaxation, curve: ForceCurve, course: FloatArray, stiffness: float) -> WallHistory:
    """Wall whose relaxed force is ``given - stiffness · depth`` (N), over a course (n, 2) of s and N given."""
    if curve.force.ndim > 1:
        raise PalpateError(
            "A robot that gives way, or keeps a force, needs one number for the force at a depth.",
            "Give the curve of the force along the wall's normal.",
            code="press-curve-missing",
        )
    history, depths, forces = StressHistory(relaxation), [], []
    for when, push in course:
        a, b = history.affine(float(when))

        def missing(depth: float, a: float = float(a), b: float = b, push: float = float(push)) -> float:
            return a + b * float(np.interp(depth, curve.depth, curve.force)) + stiffness * depth - push

        if missing(0.0) >= 0:
            depth = 0.0
        elif missing(float(curve.depth[-1])) < 0:
            raise PalpateError(
                f"After {when:.4g} s the wall goes beyond the {curve.depth[-1]:.4g} mm of the press.",
                "Press deeper, or command less.",
                code="press-curve-too-short",
            )
        else:
            depth = float(brentq(missing, 0.0, float(curve.depth[-1]), xtol=1e-12))
        depths.append(depth)
        forces.append(history.update(float(when), curve.at(np.array([depth]))[0]))
    return WallHistory(course[:, 0], np.array(depths), np.array(forces))


def _passed(curve: ForceCurve, before: float, after: float) -> FloatArray:
    """Shares of the way from one depth to another at which the curve has a corner, rising."""
    if before == after:
        return np.empty(0)
    share = (curve.depth - before) / (after - before)
    return np.sort(share[(share > 0) & (share < 1)])
