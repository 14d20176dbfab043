"""Writing and reading of a press: one HDF5 file, every array with its unit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from palpate.core import PalpateError, create_hdf5, reject_external_links
from palpate.design import build_skin, skin_from_data
from palpate.fea.derivative import Derivative
from palpate.fea.obstacles import obstacle_from_data
from palpate.fea.press import Press
from palpate.material import material_from_data
from palpate.mechanics import EndReason, SolverSpec
from palpate.mesh import MeshSpec, mesh_skin

_ARRAYS = {
    "depth": "mm",
    "displacement": "mm",
    "force": "N",
    "energy": "mJ",
    "contact_energy": "mJ",
    "dissipation": "mJ",
    "work": "mJ",
    "peak_stress": "MPa",
    "contact_area": "mm2",
    "apex_gap": "mm",
    "stabilisation_tension": "MPa",
    "negative_pivots": "1",
}
PRESS_FORMAT = "9"
"""Version of the file format; files of other versions are rejected."""
_NUMBERS = ("ended_depth", "jump_depth", "cpu_s", "unknowns", "newton_iterations")


def write_press(path: Path, press: Press) -> None:
    """Write a press. The mesh is not stored: it is built again from its spec, which takes milliseconds."""
    with create_hdf5(path) as file:
        file.attrs["kind"] = "palpate press"
        file.attrs["version"] = PRESS_FORMAT
        file.attrs["dome"] = json.dumps(press.mesh.skin.spec_data)
        file.attrs["mesh"] = press.mesh.spec.model_dump_json()
        if press.mesh.pole is not None:
            file.attrs["pole"] = press.mesh.pole
        file.attrs["material"] = json.dumps({"name": press.material.name, **press.material.key_data()})
        file.attrs["obstacle"] = press.obstacle.model_dump_json()
        file.attrs["solver"] = press.solver.model_dump_json()
        file.attrs["solved_by"] = press.solved_by
        file.attrs["ended"] = str(press.ended)
        file.attrs["message"] = press.message
        for name in _NUMBERS:
            file.attrs[name] = getattr(press, name)
        for name, unit in _ARRAYS.items():
            values = getattr(press, name)
            data = file.create_dataset(name, data=values.astype(np.float32) if name == "displacement" else values)
            data.attrs["units"] = unit
        for name, derivative in press.derivatives.items():
            group = file.create_group(f"derivatives/{name}")
            group.attrs["across"] = derivative.across
            group["displacement"] = derivative.displacement.astype(np.float32)
            group["force"] = derivative.force
        file.create_dataset("branch", data=[str(branch) for branch in press.branch], dtype=h5py.string_dtype())


def read_press(path: Path) -> Press:
    """Read a press.

    Raises
    ------
    PalpateError
        If the file is not a press of this version.
    """
    try:
        with h5py.File(path, "r") as file:
            reject_external_links(file, path)
            if file.attrs.get("kind") != "palpate press" or file.attrs["version"] != PRESS_FORMAT:
                raise PalpateError(
                    f"{path} is not a press of version {PRESS_FORMAT}.",
                    "Solve it again: `palpate run`.",
                    code="press-version",
                )
            dome = build_skin(skin_from_data(json.loads(file.attrs["dome"])))
            numbers = {name: file.attrs[name].item() for name in _NUMBERS}
            return Press(
                mesh=mesh_skin(dome, MeshSpec.model_validate_json(file.attrs["mesh"]), file.attrs.get("pole")),
                material=material_from_data(json.loads(file.attrs["material"])),
                obstacle=obstacle_from_data(json.loads(file.attrs["obstacle"])),
                solver=SolverSpec.model_validate_json(file.attrs["solver"]),
                **_read_arrays(file),
                branch=np.array(file["branch"].asstr()[()], dtype=np.str_),
                ended=EndReason(file.attrs["ended"]),
                message=str(file.attrs["message"]),
                solved_by=str(
                    file.attrs.get("solved_by", "calculix" if '"calculix"' in file.attrs["solver"] else "palpate")
                ),
                derivatives=_read_derivatives(file),
                **numbers,
            )
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise PalpateError(
            f"{path} cannot be read as a press: {error}.", "Solve it again.", code="press-unreadable"
        ) from None


def _read_derivatives(file: h5py.File) -> dict[str, Derivative]:
    return {
        name: Derivative(
            name=name,
            displacement=group["displacement"][()].astype(float),
            force=group["force"][()],
            across=bool(group.attrs["across"]),
        )
        for name, group in file.get("derivatives", {}).items()
    }


def _read_arrays(file: h5py.File) -> dict[str, Any]:
    arrays = {name: file[name][()] for name in _ARRAYS}
    arrays["displacement"] = arrays["displacement"].astype(float)
    return arrays
