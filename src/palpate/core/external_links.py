"""A file must hold what it shows: HDF5 would follow links into any other file of this machine without a word."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from palpate.core.errors import PalpateError

if TYPE_CHECKING:
    import h5py


def reject_external_links(file: h5py.File, path: Path) -> None:
    """Refuse an HDF5 file of which a part lies in another: external and virtual members, and raw data outside.

    Parameters
    ----------
    file
        The open file; nothing of its members is read.
    path
        Where it lies, for the message.

    Raises
    ------
    PalpateError
        With the name of the member.
    """
    try:
        member = _find_outside(file)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise PalpateError(
            f"{path} is a damaged HDF5 file: {error}.", "Make it again.", code="hdf5-damaged"
        ) from None
    if member:
        raise PalpateError(
            f"{path}: {member} lies in another file.",
            "Use only files that hold all of their data.",
            code="hdf5-outside-link",
        )


def _find_outside(file: h5py.File) -> str:
    """Name of a member that lies in another file; empty where there is none."""
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
