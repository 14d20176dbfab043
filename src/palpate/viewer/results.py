"""Finished result folder for the explorer: grid, and presses of one design.

Nothing is written, and every path is built here from the folder and a key of hexadecimal digits.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from palpate.camera import CameraSpec
from palpate.core import ArtefactStore, PalpateError
from palpate.design import Design, MarkerLayout, MarkerSpec, Skin, place_markers, skin_from_data
from palpate.fea import Press, read_press
from palpate.material import material_from_data
from palpate.study import Cell, SpecificationGrid, design_label, design_spec, read_grid

_LARGEST_MANIFEST = 8_000_000
"""Maximum size of a manifest, bytes."""
_AGAIN = "Run the study again."
_SIZES = ("height_mm", "base_radius_mm", "thickness_mm", "markers")
"""Required columns of a design."""


@dataclass(frozen=True, eq=False)
class Results:
    """A result folder.

    Attributes
    ----------
    folder
        The folder.
    grid
        Its specification grid, with at least one row.
    """

    folder: Path
    grid: SpecificationGrid


@dataclass(frozen=True, eq=False)
class GridDesign:
    """One row of a grid as objects that can be drawn.

    Attributes
    ----------
    number
        Number of the row, from 0.
    row
        Its figures.
    design
        Skin, markers, camera and elastomer.
    press_keys
        Keys of its presses in the store; empty for a design that failed before them.
    """

    number: int
    row: Mapping[str, Cell]
    design: Design
    press_keys: tuple[str, ...]

    @property
    def name(self) -> str:
        """Short name, e.g. ``"H20 T2, 169 markers"``."""
        return design_label(self.row)


def read_results(folder: Path) -> Results:
    """Read the grid of a result folder.

    Raises
    ------
    PalpateError
        If the folder has no grid, or the grid has no design.
    """
    grid = read_grid(folder)
    if not grid.designs:
        raise PalpateError(
            f"The grid of {folder.name} has no design.", "Give the folder of a finished study.", code="grid-empty"
        )
    for number, row in enumerate(grid.designs):
        for column in _SIZES:
            if not isinstance(row.get(column), int | float):
                raise PalpateError(
                    f"Design {number} of the grid of {folder.name} has no {column}.",
                    _AGAIN,
                    code="grid-value-missing",
                )
    return Results(folder, grid)


def read_design(results: Results, number: int) -> GridDesign:
    """Return the design of one row.

    Raises
    ------
    PalpateError
        If the row does not exist, or is incomplete.
    """
    if not 0 <= number < len(results.grid.designs):
        raise PalpateError(
            f"There is no design {number}.",
            f"The grid has designs 0 to {len(results.grid.designs) - 1}.",
            code="design-unknown",
        )
    row = results.grid.designs[number]
    try:
        sizes = {name: row[f"{name}_mm"] for name in ("height", "base_radius", "thickness")}
        spec = design_spec(row)
        skin = skin_from_data(spec.get("skin", {}) | sizes)
        layout = _read_layout(results, row, skin.build())
        material = {"material": material_from_data({"name": "", **spec["material"]})} if "material" in spec else {}
        design = Design(skin, layout, CameraSpec(**spec.get("camera", {})), **material)
        return GridDesign(number, row, design, _keys(row, "press"))
    except (KeyError, TypeError, ValueError, ValidationError) as error:
        raise PalpateError(
            f"Row {number} of the grid is no design: {error}.", _AGAIN, code="design-row-unreadable"
        ) from None


def read_presses(results: Results, design: GridDesign) -> tuple[Press, ...]:
    """Return all presses of a design, by ascending tilt.

    Raises
    ------
    PalpateError
        If there are no presses, or one is missing or broken.
    """
    if not design.press_keys:
        reason = design.row.get("failure") or "its chain broke before the first press"
        raise PalpateError(f"{design.name} has no press: {reason}", _AGAIN, code="press-missing")
    presses = (read_press(artefact_path(results, "press", key, ".h5")) for key in design.press_keys)
    return tuple(sorted(presses, key=lambda press: press.obstacle.radial))


def artefact_path(results: Results, kind: str, key: str, suffix: str) -> Path:
    """Return the path of an artefact in the store of a result folder.

    Raises
    ------
    PalpateError
        If the key is invalid, or the file is missing.
    """
    path = ArtefactStore(results.folder / "store").locate(kind, key, suffix)
    if not path.is_file():
        raise PalpateError(
            f"The {kind} {key[:8]}… is not in the store of {results.folder.name}.", _AGAIN, code="artefact-not-stored"
        )
    return path


def model_path(results: Results, design: GridDesign) -> Path:
    """Return the path of a design's trained estimator, an ONNX file.

    Raises
    ------
    PalpateError
        If the design has no estimator.
    """
    kind = "forces" if _keys(design.row, "forces") else "estimator"
    keys = _keys(design.row, kind)
    if not keys:
        raise PalpateError(
            f"{design.name} has no trained model.", "Choose a design that was learned.", code="model-missing"
        )
    return artefact_path(results, kind, keys[0], ".onnx")


def _keys(row: Mapping[str, Cell], kind: str) -> tuple[str, ...]:
    return tuple(str(row.get(f"{kind}_key") or "").split())


def _read_layout(results: Results, row: Mapping[str, Cell], skin: Skin) -> MarkerLayout:
    """Markers of the dataset; without one, of the design's spec, or rings of the same number of markers."""
    spec = design_spec(row)
    markers = spec.get("markers", {})
    for key in _keys(row, "dataset"):
        path = ArtefactStore(results.folder / "store").locate("dataset", key, ".manifest.json")
        if path.is_file() and path.stat().st_size <= _LARGEST_MANIFEST:
            found: Any = json.loads(path.read_bytes()).get("spec", {}).get("markers_mm")
            positions = np.asarray(found, float)
            if positions.ndim == 2 and positions.shape[1] == 3 and len(positions) == row["markers"]:
                return MarkerLayout(positions, float(markers.get("diameter", MarkerSpec().diameter)))
    return place_markers(skin, MarkerSpec.model_validate({"count": row["markers"], **markers}))
