"""Flags on the columns of a table of poses, for every command that reads one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from cyclopts import Parameter

from palpate.datasets import ColumnMapping

_IMAGE = (
    "Column of the image names or numbers, if it is not recognised by its name; the camera of a LeRobot dataset, the "
    "array of an HDF5, NPZ or Zarr file, the topic of a ROS bag, or the folder of images, if there are several."
)
_PRESS = "Column of the press that an image belongs to; without it, each image is a separate press."
_ANGLES = "Unit of angles whose column has no unit in its name."
_LENGTHS = "Unit of lengths whose column has no unit in its name."
_ORIENTATION = (
    "Kind of the orientation: rotvec (rotation vector rx, ry, rz), xyzw or wxyz (quaternion), matrix, or the order "
    "of Euler angles: lower case about fixed axes, upper case about rotated axes (xyz, ZYX). It is converted to the "
    "rotation vector of the tilt relative to the surface. Without it, names and values decide."
)
_FRAME = (
    "Surface in the frame of the poses: a point in mm and the outward normal, x,y,z,nx,ny,nz. Without it, poses are "
    "relative to the surface, or it is estimated from them."
)


@Parameter(name="*")
@dataclass(frozen=True)
class ColumnFlags:
    """Meaning and units of the columns of a table of poses."""

    image: Annotated[str | None, Parameter(help=_IMAGE)] = None
    press: Annotated[str | None, Parameter(help=_PRESS)] = None
    angles: Annotated[Literal["deg", "rad"] | None, Parameter(help=_ANGLES)] = None
    lengths: Annotated[Literal["mm", "m"] | None, Parameter(help=_LENGTHS)] = None
    orientation: Annotated[str | None, Parameter(name=("--orientation", "--euler"), help=_ORIENTATION)] = None
    frame: Annotated[str | None, Parameter(help=_FRAME, allow_leading_hyphen=True)] = None

    def mapping(self, targets: str | None = None) -> ColumnMapping:
        """Return the column mapping of these flags, which the reader accepts."""
        return ColumnMapping(
            tuple(name.strip() for name in (targets or "").split(",") if name.strip()),
            self.image or "",
            self.press or "",
            self.angles or "",
            self.lengths or "",
            self.orientation or "",
            self.frame or "",
        )
