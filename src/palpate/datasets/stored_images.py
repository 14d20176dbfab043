"""Images in arrays: grey or colour, channels last or first, any type, or rows of JPEG files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from palpate.camera import decode_image
from palpate.core import PalpateError
from palpate.core.units import is_unit, split_unit
from palpate.datasets.table import Column

_FILES = (b"\xff\xd8\xff", b"\x89PNG")
"""First bytes of JPEG and PNG files."""
_LEAST_PX = 8
"""Minimum side of an image; shorter axes of an array are channels or vectors. By hand."""


def holds_images(array: Any) -> bool:
    """Return whether an array (of HDF5, NPZ or Zarr) of n rows has an image in each."""
    shape, kind = tuple(array.shape), array.dtype.kind
    if not shape or not shape[0]:
        return False
    if len(shape) == 4 and kind in "uif":
        first, last = shape[1] in (1, 3, 4), shape[3] in (1, 3, 4)
        sides = shape[2:] if first and not last else shape[1:3]
        return (first or last) and min(sides) >= _LEAST_PX
    if len(shape) == 3 and kind in "uifb" and min(shape[1:]) >= _LEAST_PX:
        if kind in "ub":
            return True
        image = np.asarray(array[0])
        whole = kind == "i" or bool((image == np.round(image)).all())  # grey levels as floats are whole
        return float(image.min()) >= 0.0 and float(image.max()) <= (65535.0 if whole else 1.0)
    if (len(shape) == 1 and kind in "OSV") or (len(shape) == 2 and array.dtype == np.uint8 and shape[1] >= 64):
        return _file_content(array[0]).startswith(_FILES)
    return False


def read_row(array: Any, row: int) -> NDArray[Any]:
    """Return image `row` of an array that `holds_images`: (h, w) or (h, w, c).

    Raises
    ------
    PalpateError
        If it is a file that cannot be decoded.
    """
    if array.ndim <= 2:
        return decode_image(_file_content(array[row]), f"Image {row} of {getattr(array, 'name', 'the array')}")
    image = np.asarray(array[row])
    if image.dtype.kind == "b":
        image = image * np.uint8(255)
    if image.ndim == 3 and image.shape[2] not in (1, 3, 4):
        image = np.moveaxis(image, 0, -1)
    if image.dtype.kind == "f" and not np.isfinite(image).all():
        raise PalpateError(
            f"Image {row} holds values that are not numbers.", "Repair or leave it out.", code="image-not-finite"
        )
    return np.ascontiguousarray(image)


def _file_content(cell: Any) -> bytes:
    if isinstance(cell, bytes | np.bytes_):
        return bytes(cell)
    try:
        return np.asarray(cell).astype(np.uint8, copy=False).tobytes()
    except (TypeError, ValueError):
        return b""


def list_arrays(arrays: Mapping[str, Any]) -> str:
    """Names, shapes and types of the first arrays of a file, as a clause."""
    found = [f"{name} {array.shape} {array.dtype}" for name, array in list(arrays.items())[:5]]
    return f", but {', '.join(found)}" if found else ""


def merge_columns(arrays: Iterable[tuple[list[str], Any, Mapping[str, Any]]]) -> dict[str, Column]:
    """Columns of arrays, given with their paths and attributes; a name of two columns gets its path."""
    found = [(path, name_columns(path[-1], array, attributes)) for path, array, attributes in arrays]
    counts = Counter(name for _, columns in found for name in columns)
    return {
        name if counts[name] == 1 else "_".join([*(path if name != path[-1] else path[:-1]), name]): column
        for path, columns in found
        for name, column in columns.items()
    }


def name_columns(key: str, array: Any, attributes: Mapping[str, Any]) -> dict[str, Column]:
    """Columns of an array of n rows: its fields, texts, or numbers (n, k) by their names.

    Attributes of the array (HDF5) may be ``columns`` or ``names``, and ``units`` or ``unit``. Without names, columns
    are called by the key and 0 to k - 1.
    """
    values = np.asarray(array[:])
    if values.dtype.names:
        fields = (name_columns(field, values[field], {}) for field in values.dtype.names)
        return {name: column for columns in fields for name, column in columns.items()}
    if values.ndim == 1 and values.dtype.kind == "U":
        return {key: values}
    if values.dtype.kind not in "iufb" or values.ndim > 2:
        return {}
    values = values.astype(float).reshape(len(values), -1)
    names = _texts(attributes.get("columns", attributes.get("names", ())))
    units = _texts(attributes.get("units", attributes.get("unit", ())))
    if len(names) != values.shape[1]:
        names = [key] if values.shape[1] == 1 else [f"{key}_{number}" for number in range(values.shape[1])]
    units = units * len(names) if len(units) == 1 else units
    if len(units) == len(names):
        names = [
            f"{name} [{unit}]" if is_unit(unit) and not split_unit(name)[1] else name
            for name, unit in zip(names, units, strict=True)
        ]
    return {name: values[:, number] for number, name in enumerate(names)}


def _texts(value: Any) -> list[str]:
    if isinstance(value, h5py.Empty):
        return []
    texts = [one.decode() if isinstance(one, bytes) else str(one) for one in np.atleast_1d(value).tolist()]
    return [text.strip() for text in texts[0].split(",")] if len(texts) == 1 else texts


def join_parts(name: str, parts: Sequence[dict[str, Column]], held: str = "") -> dict[str, Column]:
    """Columns that all parts of a recording have, concatenated; `held` is `list_arrays` of its file.

    Raises
    ------
    PalpateError
        If they share none but the press.
    """
    shared = set.intersection(*(set(part) for part in parts))
    if not shared - {"press"}:
        raise PalpateError(
            f"{name} has no numbers with as many rows as images{held}.",
            "Give poses as arrays of n rows for n images.",
            code="recording-no-table",
        )
    return {key: np.concatenate([part[key] for part in parts]) for key in parts[0] if key in shared}
