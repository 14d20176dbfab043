"""Force and depth through time of a held obstacle, from the force of one press.

A press gives the force at every depth of an elastic skin. If the depth is prescribed, the shape of the skin at every
time is that of the press, since one function relaxes all stresses alike, and the force is the relaxed elastic one. If
the robot is compliant, or holds a force, the depth is unknown as well: one equation a time.
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
    """Force by depth of an elastic press, linear between its increments.

    Attributes
    ----------
    depth
        (n,) mm, ascending from 0.
    force
        (n,) N along the wall's normal, or (n, 3) N.

    Raises
    ------
    PalpateError
        If the depths do not ascend, as those of a retracted press, or depths and forces differ in number.
    """

    depth: FloatArray
    force: FloatArray

    def __post_init__(self) -> None:
        if len(self.depth) != len(self.force) or not (np.diff(self.depth) > 0).all():
            raise PalpateError(
                f"{len(self.depth)} depths and {len(self.force)} forces do not form the curve of a loading press.",
                "Give ascending depths and a force for each; of a retracted press, the loading part.",
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
    """Compute the force on a wall of prescribed depth, as on a stiff robot.

    Parameters
    ----------
    relaxation
        Relaxation of the skin.
    curve
        Force of the elastic press.
    time
        (n,) s, non-decreasing.
    depth
        (n,) mm, linear between the times; the first is reached at once.

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
    """Compute force and depth of a wall on a compliant robot, which sinks in as the force relaxes.

    At every time, ``stiffness · (travel - depth)`` is the force.

    Parameters
    ----------
    relaxation
        Relaxation of the skin.
    curve
        Force of the elastic press along the wall's normal.
    time
        (n,) s, ascending; the elastic force is linear between them, so give them densely.
    travel
        (n,) mm commanded to the robot, as if it were stiff.
    stiffness
        Stiffness of the robot along its travel, N/mm.

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
    """Compute the depth of a wall on which a robot holds a force.

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
    """Times and the prescribed values, (n, 2)."""
    time, given = np.asarray(time, float), np.asarray(given, float)
    if time.ndim != 1 or time.shape != given.shape:
        raise PalpateError(
            f"There are {time.size} times and {given.size} values.",
            "Give one value for every time.",
            code="course-lengths-differ",
        )
    return np.column_stack([time, given])


def _balance(relaxation: Relaxation, curve: ForceCurve, course: FloatArray, stiffness: float) -> WallHistory:
    """Wall with the relaxed force ``given - stiffness · depth`` (N), over a history (n, 2) of s and N."""
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
    """Shares of the way between two depths at which the curve has a corner, ascending."""
    if before == after:
        return np.empty(0)
    share = (curve.depth - before) / (after - before)
    return np.sort(share[(share > 0) & (share < 1)])
