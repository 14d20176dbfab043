"""Force and depth through time of an obstacle that comes down and stays, from the force of one press.

A press knows the force at every depth of an elastic skin. Where the depth follows a course, the shape of the skin at
every time is that of the press, since one function relaxes all stresses alike, and its force is the elastic one
relaxed. Where the robot gives way, or holds its force, the depth is part of what is sought: one equation a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from palpate.core import FloatArray, PalpateError
from palpate.relaxation.history import StressHistory
from palpate.relaxation.relaxation import Relaxation


@dataclass(frozen=True, eq=False)
class ForceCurve:
    """Force over depth of an elastic press, straight between its increments.

    Attributes
    ----------
    depth
        (n,) mm, rising from 0.
    force
        (n,) N along the wall's normal, or (n, 3) N.
    """

    depth: FloatArray
    force: FloatArray

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
            )
        if self.force.ndim == 1:
            return np.interp(depth, self.depth, self.force)
        return np.column_stack([np.interp(depth, self.depth, part) for part in self.force.T])


class WallCourse(NamedTuple):
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


def hold_wall(relaxation: Relaxation, curve: ForceCurve, time: FloatArray, depth: FloatArray) -> WallCourse:
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
    WallCourse
        At these times; exact for this curve.
    """
    time, depth = np.asarray(time, float), np.asarray(depth, float)
    history, forces = StressHistory(relaxation), []
    for number, (when, there) in enumerate(zip(time, depth, strict=True)):
        for share in _passed(curve, depth[number - 1], there) if number else ():
            between = depth[number - 1] + share * (there - depth[number - 1])
            at = time[number - 1] + share * (when - time[number - 1])
            history.follow(float(at), curve.at(np.array([between]))[0])
        forces.append(history.follow(float(when), curve.at(np.array([there]))[0]))
    return WallCourse(time, depth, np.array(forces))


def sink_wall(
    relaxation: Relaxation, curve: ForceCurve, time: FloatArray, travel: FloatArray, stiffness: float
) -> WallCourse:
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
    WallCourse
        At these times.

    Raises
    ------
    PalpateError
        If the stiffness is not positive, or the wall goes beyond the press.
    """
    if not 0 < stiffness < np.inf:
        raise PalpateError(f"The robot's stiffness is {stiffness:g} N/mm.", "Give one above 0.")
    given = np.asarray(travel, float)
    return _balance(relaxation, curve, np.asarray(time, float), stiffness * given, stiffness)


def hold_force(relaxation: Relaxation, curve: ForceCurve, time: FloatArray, force: FloatArray) -> WallCourse:
    """Follow a wall on which a robot keeps a force: it creeps in.

    Parameters
    ----------
    relaxation, curve, time
        As for `sink_wall`.
    force
        (n,) N along the wall's normal.

    Returns
    -------
    WallCourse
        At these times.

    Raises
    ------
    PalpateError
        If the wall goes beyond the press.
    """
    return _balance(relaxation, curve, np.asarray(time, float), np.asarray(force, float), 0.0)


def _balance(
    relaxation: Relaxation, curve: ForceCurve, time: FloatArray, given: FloatArray, stiffness: float
) -> WallCourse:
    """Depths (n,) at which the relaxed force and ``given - stiffness · depth`` (N) are one."""
    history, depths, forces = StressHistory(relaxation), [], []
    for when, push in zip(time, given, strict=True):
        a, b = history.affine(float(when))

        def missing(depth: float, a: float = float(a), b: float = b, push: float = float(push)) -> float:
            return a + b * float(np.interp(depth, curve.depth, curve.force)) + stiffness * depth - push

        if missing(0.0) >= 0:
            depth = 0.0
        elif missing(float(curve.depth[-1])) < 0:
            raise PalpateError(
                f"After {when:.4g} s the wall goes beyond the {curve.depth[-1]:.4g} mm of the press.",
                "Press deeper, or command less.",
            )
        else:
            depth = float(brentq(missing, 0.0, float(curve.depth[-1]), xtol=1e-12))
        depths.append(depth)
        forces.append(history.follow(float(when), curve.at(np.array([depth]))[0]))
    return WallCourse(time, np.array(depths), np.array(forces))


def _passed(curve: ForceCurve, before: float, after: float) -> FloatArray:
    """Shares of the way from one depth to another at which the curve has a corner, rising."""
    if before == after:
        return np.empty(0)
    share = (curve.depth - before) / (after - before)
    return np.sort(share[(share > 0) & (share < 1)])
