"""The noun of one unit: marker positions and labels of all its images, some rendered, and what it shows at rest."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, IntArray, create_hdf5, reject_external_links

LABELS = ("rx_deg", "ry_deg", "depth_mm", "force_n", "shear_n", "friction")
"""Labels that are numbers; friction is the coefficient, infinite where nothing slips."""


@dataclass(frozen=True, eq=False)
class UnitImages:
    """What was seen of one unit.

    Attributes
    ----------
    markers_px
        (n, m, 2) dots as a detector finds them, in single precision; NaN for a dot that is not there.
    rest_px
        (m, 2) the same at rest.
    labels
        (n, 6) by `LABELS`.
    inverted
        (n,) whether the skin stands in its other state.
    press
        (n,) number of the press, from 0.
    pictured
        (k,) images that were rendered as well.
    pictures
        (k + 1, h, w) of 8 bit, the one at rest first; empty where none was asked for.
    """

    markers_px: NDArray[np.float32]
    rest_px: NDArray[np.float32]
    labels: FloatArray
    inverted: NDArray[np.bool_]
    press: IntArray
    pictured: IntArray
    pictures: NDArray[np.uint8]


def write_unit_images(path: Path, found: UnitImages) -> None:
    """Write what was seen of one unit."""
    with create_hdf5(path) as file:
        for field in fields(found):
            file.create_dataset(field.name, data=getattr(found, field.name))


def read_unit_images(path: Path) -> UnitImages:
    """Read what `write_unit_images` wrote.

    Raises
    ------
    PalpateError
        If the file refers to another one.
    """
    with h5py.File(path, "r") as file:
        reject_external_links(file, path)
        return UnitImages(**{field.name: file[field.name][()] for field in fields(UnitImages)})
