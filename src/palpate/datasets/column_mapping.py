"""Meaning of the columns of a recording, as its user states it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, eq=False)
class ColumnMapping:
    """Meaning and units of columns that a table does not state itself.

    Attributes
    ----------
    targets
        Columns to estimate, ``pose_4=rx_deg`` if the name does not state the quantity; empty for rx, ry and depth
        if they exist, else all.
    image, press
        Names of these columns; empty if recognised.
    angles, lengths
        Units of columns without a unit, ``deg`` or ``rad``, ``mm`` or ``m``; empty if the values decide.
    euler
        Orientation of three or more columns: order of Euler angles, as scipy names it (``xyz`` about fixed axes,
        ``XYZ`` about rotated ones), ``rotvec``, ``xyzw`` or ``wxyz`` for quaternions, ``matrix``; empty if names and
        values state it, or angles are a tilt as they stand.
    frame
        Point of the pressed surface in mm and its outward normal, in the frame of the poses: ``x,y,z,nx,ny,nz``,
        empty if poses are relative to it, or it is estimated.
    pose
        Topic of the poses of a ROS bag; empty if it has one.
    forces
        Table of forces with their times.
    times, force_unit
        Units of times and of forces without a unit: ``s``, ``ms``, ``us`` or ``ns``; ``N``, ``mN``, ``kN``, ``gf``, …
    """

    targets: tuple[str, ...] = ()
    image: str = ""
    press: str = ""
    angles: str = ""
    lengths: str = ""
    euler: str = ""
    frame: str = ""
    pose: str = ""
    forces: Path | None = None
    times: str = ""
    force_unit: str = ""
