"""Simulated images of one unit, and their file."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, IntArray, create_hdf5, reject_external_links

LABELS = ("rx_deg", "ry_deg", "depth_mm", "force_n", "shear_n", "friction")
"""Numeric labels; friction is the coefficient, infinite for no slip."""


@dataclass(frozen=True, eq=False)
class UnitImages:
    """Simulated images of one unit.

    Attributes
    ----------
    markers_px
        (n, m, 2) marker positions with noise, in single precision; NaN for a missing marker.
    rest_px
        (m, 2) marker positions with noise at rest.
    labels
        (n, 6) by `LABELS`.
    inverted
        (n,) whether the skin is on the inverted branch.
    press
        (n,) number of the press, from 0.
    pictured
        (k,) rows of the images that were rendered.
    pictures
        (k + 1, h, w) rendered images of 8 bit, the rest image first; empty if none was requested.
    """

    markers_px: NDArray[np.float32]
    rest_px: NDArray[np.float32]
    labels: FloatArray
    inverted: NDArray[np.bool_]
    press: IntArray
    pictured: IntArray
    pictures: NDArray[np.uint8]


def write_unit_images(path: Path, found: UnitImages) -> None:
    """Write the images of one unit."""
    with create_hdf5(path) as file:
        for field in fields(found):
            file.create_dataset(field.name, data=getattr(found, field.name))


def read_unit_images(path: Path) -> UnitImages:
    """Read a file of `write_unit_images`.

    Raises
    ------
    PalpateError
        If the file contains external links.
    """
    with h5py.File(path, "r") as file:
        reject_external_links(file, path)
        return UnitImages(**{field.name: file[field.name][()] for field in fields(UnitImages)})
