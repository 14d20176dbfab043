"""Output of a command: JSON or tables on standard output, and checks of its output files."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from collections.abc import Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from palpate.core import PalpateError, Spec
from palpate.core.report import Report, json_text, report_text, wrapped

RESULTS = Path("results")
"""Folder of the result folders, without --out."""
OutFlag = Annotated[Path | None, Parameter(name=("--out", "-o"), help="Result folder; by default results/NAME.")]


_INPUTS: ContextVar[dict[str, Any] | None] = ContextVar("inputs", default=None)


def keep_inputs(words: Sequence[str], flags: Mapping[str, Any]) -> None:
    """Keep the words of the command and the values of its flags, defaults included, for its JSON."""
    values = {name: value for name, value in flags.items() if not isinstance(value, JsonOutput)}
    _INPUTS.set({"command": shlex.join(words), **_values(values)})


def _values(value: Any) -> Any:
    if isinstance(value, Spec):
        return value.model_dump(mode="json")
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _values(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(name): _values(each) for name, each in value.items()}
    if isinstance(value, list | tuple | set):
        return [_values(each) for each in value]
    return value if value is None or isinstance(value, bool | int | float) else str(value)


def _with_inputs(data: Any) -> dict[str, Any]:
    """Return the data of a command with its inputs; a list of rows becomes the entry `rows`."""
    return {"inputs": _INPUTS.get(), **(data if isinstance(data, Mapping) else {"rows": data})}


@Parameter(name="*")
@dataclass(frozen=True)
class JsonOutput:
    """Flag of a command that prints sentences or JSON.

    Attributes
    ----------
    json
        Whether JSON is printed, and only JSON.
    """

    json: Annotated[bool, Parameter(name="--json", negative="", help="Print only JSON.")] = False

    def show(self, data: Any, *sentences: str) -> None:
        """Print the data as JSON with --json, otherwise the sentences."""
        if self.json:
            print(json_text(_with_inputs(data)))
            return
        for sentence in sentences:
            print_text(sentence)


@Parameter(name="*")
@dataclass(frozen=True)
class Output(JsonOutput):
    """Flags of a command that prints tables.

    Attributes
    ----------
    wide
        Whether all columns of a table are printed, with their legend.
    """

    wide: Annotated[
        bool, Parameter(name="--wide", negative="", help="Print all columns of tables, with a legend.")
    ] = False

    def show(self, data: Any, *reports: Report | str) -> None:
        """Print the data as JSON with --json, otherwise reports and sentences in their order."""
        if self.json:
            print(json_text(_with_inputs(data)))
            return
        above: Report | str = ""
        for report in reports:
            if above and not (isinstance(report, str) and isinstance(above, str)):
                print()
            if isinstance(report, str):
                print_text(report)
            else:
                print(report_text(report, terminal_width(), wide=self.wide), flush=True)
            above = report


def terminal_width() -> int | None:
    """Return the number of columns of the terminal; `None` if standard output is not a terminal."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def print_text(text: str) -> None:
    """Print a text, wrapped to the width of the terminal."""
    print("\n".join(wrapped(text, terminal_width())), flush=True)


def check_file(path: Path | None, *endings: str) -> None:
    """Reject an output file that cannot be written, before the computation; `None` is accepted.

    Raises
    ------
    PalpateError
        If its name has a wrong ending, it is a folder, or its folder is missing or read-only.
    """
    if path is None:
        return
    if endings and path.suffix.lower() not in endings:
        raise PalpateError(
            f"{path.name} does not end in {' or '.join(endings)}.",
            "Give a file name with this ending.",
            code="file-ending-unknown",
        )
    if path.is_dir():
        raise PalpateError(f"{path} is a folder.", "Name a file in it.", code="file-is-folder")
    if not path.parent.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        reason = "is read-only" if path.parent.is_dir() else "is not an existing folder"
        raise PalpateError(
            f"{path} cannot be written: {path.parent} {reason}.",
            "Name a file in another folder.",
            code="file-unwritable",
        )


def check_folder(path: Path | None) -> None:
    """Reject an output folder that cannot be made or written to; `None` is accepted.

    Raises
    ------
    PalpateError
        If it, or the nearest existing folder above it, is a file or read-only.
    """
    if path is None:
        return
    there = next(place for place in (path, *path.absolute().parents) if place.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        reason = "is read-only" if there.is_dir() else "is a file"
        raise PalpateError(
            f"The folder {path} cannot be written: {there} {reason}.",
            "Choose another folder.",
            code="folder-unwritable",
        )
