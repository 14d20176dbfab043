"""Named arrays of numbers, truth values and texts in one HDF5 file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from palpate.core.external_links import reject_external_links
from palpate.core.files import create_hdf5

_TEXT = "text"


def write_arrays(path: Path, arrays: Mapping[str, Any]) -> None:
    """Write arrays under their names."""
    with create_hdf5(path) as file:
        for name, given in arrays.items():
            array = np.asarray(given)
            is_text = array.dtype.kind == "U"
            file.create_dataset(name, data=np.char.encode(array, "utf-8") if is_text else array)
            file[name].attrs[_TEXT] = is_text


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Read a file of `write_arrays`.

    Raises
    ------
    PalpateError
        If the file refers to another one.
    """
    with h5py.File(path, "r") as file:
        reject_external_links(file, path)
        return {
            name: np.char.decode(kept[()], "utf-8") if kept.attrs[_TEXT] else kept[()] for name, kept in file.items()
        }
