"""Rejection of HDF5 files with links, which HDF5 would follow into any file of this machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from palpate.core.errors import PalpateError

if TYPE_CHECKING:
    import h5py


def reject_external_links(file: h5py.File, path: Path) -> None:
    """Raise an error if a part of an HDF5 file is in another file.

    External and virtual members and external raw data are rejected; the members of the open file are not read. `path`
    is that of the message.

    Raises
    ------
    PalpateError
        With the name of the member.
    """
    try:
        member = _find_outside(file)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise PalpateError(
            f"{path} is a damaged HDF5 file: {error}.", "Make the file again.", code="hdf5-damaged"
        ) from None
    if member:
        raise PalpateError(
            f"{path}: {member} is stored in another file.",
            "Use only files that contain all of their data.",
            code="hdf5-outside-link",
        )


def _find_outside(file: h5py.File) -> str:
    """Return the name of a member that is stored in another file, or an empty text."""
    import h5py

    groups: list[tuple[str, h5py.Group]] = [("", file)]
    seen: set[int] = set()
    while groups:
        place, group = groups.pop()
        for name in group:
            member = f"{place}{name}"
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                return member
            if not isinstance(link, h5py.HardLink):
                continue  # a soft link leads to a place in this file, which is looked at by itself
            found = group[name]
            if isinstance(found, h5py.Dataset) and (found.is_virtual or found.external):
                return member
            if isinstance(found, h5py.Group) and (number := h5py.h5o.get_info(found.id).addr) not in seen:
                seen.add(number)
                groups.append((f"{member}/", found))
    return ""
