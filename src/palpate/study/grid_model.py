"""Export of the trained estimator of a design from the store of its study."""

from __future__ import annotations

import shutil
from pathlib import Path

from palpate.core import ArtefactStore, PalpateError, wrap_write_errors
from palpate.learn import open_predictor
from palpate.study.grid import SpecificationGrid, design_label


def copy_model(directory: Path, grid: SpecificationGrid, out: Path) -> str:
    """Copy the model of the first row of a grid to `out`, a stand-alone ONNX file.

    Parameters
    ----------
    directory
        Result folder of the study, with its store.
    grid
        Its grid, filtered and sorted so that the design wanted comes first.
    out
        File to write; an existing one is replaced.

    Returns
    -------
    str
        Label of the design.

    Raises
    ------
    PalpateError
        If the grid has no row, its design has no model, or a file cannot be read or written.
    """
    if not grid.designs:
        raise PalpateError(
            "No design of the grid is left.", "Choose fewer conditions in --where.", code="grid-selection-empty"
        )
    row = grid.designs[0]
    name = design_label(row)
    kind = "forces" if row.get("forces_key") else "estimator"  # the same estimator, which tells forces as well
    key = row.get(f"{kind}_key")
    if not isinstance(key, str) or not key:
        raise PalpateError(f"{name} has no model.", "Its chain broke: see the column failure.", code="model-missing")
    path = ArtefactStore(directory / "store").locate(kind, key, ".onnx")
    if not path.is_file():
        raise PalpateError(
            f"The model of {name} is not in {directory / 'store'}.",
            "Run the study again.",
            code="artefact-not-stored",
        )
    open_predictor(path)
    with wrap_write_errors(out):
        shutil.copyfile(path, out)
    return name
