"""Results of a viewer: found below a folder, described for their list, and opened by name."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import h5py

from palpate.core import PalpateError
from palpate.fea import Press, read_press
from palpate.optimise import SearchFolder, is_search, read_search
from palpate.study import is_grid
from palpate.surrogate import Twin, read_twin
from palpate.viewer.design_cache import DesignCache
from palpate.viewer.library import DesignLibrary
from palpate.viewer.results import read_results
from palpate.viewer.trained import TrainedSensor, is_trained_sensor, read_trained_sensor

OpenedResult = DesignLibrary | SearchFolder | TrainedSensor | Press | Twin

_PLACES = ("*", "*/*", "*/twins/*")
"""Patterns of the paths at which results are searched."""
_FOLDERS = {"study": is_grid, "search": is_search, "model of a recording": is_trained_sensor}
"""Kind of a folder → its test."""
_MARKS = {"palpate press": "press", "palpate calibration predict": "twin"}
"""Attribute `kind` of an HDF5 file → kind of the result."""
_READERS: dict[str, Callable[[Path], OpenedResult]] = {
    "study": lambda path: DesignLibrary(read_results(path)),
    "search": read_search,
    "model of a recording": read_trained_sensor,
    "press": read_press,
    "twin": read_twin,
}
_DRAFTS = ("-wal", "-shm")
"""Ends of the files that SQLite writes while a grid is read."""


def kind_of(path: Path) -> str:
    """Kind of a result; empty for any other path, and for one that cannot be opened."""
    try:
        if path.is_dir():
            return next((kind for kind, test in _FOLDERS.items() if test(path)), "")
        if path.suffix != ".h5":
            return ""
        with h5py.File(path, "r") as file:
            return _MARKS.get(str(file.attrs.get("kind")), "")
    except OSError:
        return ""


def find_results(folder: Path) -> dict[str, Path]:
    """Results below a folder by their relative names; a result that is given itself has the name ``""``."""
    if kind_of(folder):
        return {"": folder}
    found = {path.relative_to(folder).as_posix(): path for place in _PLACES for path in folder.glob(place)}
    hidden = {name for name in found if name.startswith(".") or "/." in name}
    return {name: found[name] for name in sorted(found.keys() - hidden) if kind_of(found[name])}


def describe_result(path: Path) -> tuple[str, str, str]:
    """Kind, number of designs or presses, and date; an unreadable result has the reason as number."""
    kind, date = kind_of(path), ""
    try:
        files = [path] if path.is_file() else [one for one in path.iterdir() if not one.name.endswith(_DRAFTS)]
        date = f"{datetime.fromtimestamp(max(one.stat().st_mtime for one in files)):%Y-%m-%d %H:%M}"
        number = _number(_READERS[kind](path))
    except (PalpateError, OSError) as error:
        number = str(error)
    return kind, number, date


def _number(result: OpenedResult) -> str:
    """Number of designs or presses of a result, as text."""
    match result:
        case DesignLibrary():
            count, nouns = len(result.results.grid.designs), ("design", "designs")
        case SearchFolder():
            count, nouns = result.skins, ("skin", "skins")
        case TrainedSensor():
            count, nouns = result.model.about["presses"], ("press", "presses")
        case _:
            count, nouns = result.max_depth_mm.size if isinstance(result, Twin) else 1, ("press", "presses")
    return f"{count} {nouns[count != 1]}"


class OpenedResults:
    """Results of a viewer.

    Parameters
    ----------
    path
        A result, or a folder of results; `None` without results.

    Attributes
    ----------
    shelf
        Cache from which the browser requests designs; it has the designs of opened studies.
    sensors
        Opened models of recordings by name.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.shelf = DesignCache()
        self.sensors: dict[str, TrainedSensor] = {}

    def find(self) -> dict[str, Path]:
        """Results by name, as they are now."""
        return {} if self.path is None else find_results(self.path)

    def open(self, name: str) -> OpenedResult:
        """Open a result; a study and a model of a recording are read once.

        Raises
        ------
        PalpateError
            If it does not exist or cannot be read.
        """
        if self.path is None:
            raise PalpateError("No result folder was given.", "Give one to `palpate view`.", code="results-missing")
        known = self.shelf.libraries.get(name) or self.sensors.get(name)
        if known is not None:
            return known
        path = self.find().get(name)
        if path is None:
            raise PalpateError(
                f"There is no result '{name[:60]}' in {self.path}.", "Open one of the list.", code="result-unknown"
            )
        result = _READERS[kind_of(path)](path)
        if isinstance(result, DesignLibrary):
            self.shelf.libraries[name] = result
        elif isinstance(result, TrainedSensor):
            self.sensors[name] = result
        return result
