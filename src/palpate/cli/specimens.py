"""`palpate design specimens`: molds of the test specimens to which a material is fitted."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.cli.flag import flags_of
from palpate.cli.output import JsonOutput, check_folder
from palpate.fabrication import ProcessSpec, write_specimen_molds

_OUT = "New folder for the molds."
_COUNT = "Number of specimens per tray, of each kind."


def specimens(
    *,
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    count: Annotated[int, Parameter(help=_COUNT)] = 5,
    process: Annotated[ProcessSpec, flags_of(ProcessSpec, only="shrinkage_percent")] = ProcessSpec(),
    output: JsonOutput = JsonOutput(),
) -> None:
    """Write molds of dumbbells (ASTM D412 die C) and cylinders (ASTM D395 type 1)."""
    check_folder(out)
    files = write_specimen_molds(out, process, count)
    output.show({"folder": str(out), "sha256": files}, f"{len(files) + 1} files in {out}")
