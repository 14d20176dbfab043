"""Write and read a twin: one HDF5 file, every array with its unit."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from palpate.core import PalpateError, create_hdf5, provenance, reject_external_links, stage_version
from palpate.design import Skin, build_skin, skin_from_data
from palpate.material import Material, Relaxation, material_from_data
from palpate.surrogate.tensor_spline import TensorSpline
from palpate.surrogate.twin import FORCES, Twin

TWIN_VERSION = "4"
"""Version of the code that determines the values of a twin; part of its file and of an artefact's key."""
_KIND = "palpate calibration predict"
_AGAIN = "Make it again with `palpate calibration predict`."
_INVERTED = "inverted"
"""Group of the inverted branch."""
_PARTS = 3
"""Fields in each spline: press, thickness, curvature; lateral x, y, twist."""
_ARRAYS = {
    "order": "1",
    "modes": "1",
    "tilts_deg": "deg",
    "depths_mm": "mm",
    "inverse_frictions": "1",
    "max_depth_mm": "mm",
}


def twin_path(folder: Path, skin: Skin) -> Path:
    """Return the path of the twin of a skin in a result folder."""
    return folder / "twins" / f"{skin.name.replace(' ', '_')}.h5"


def find_twin(
    results: Path, skin: Skin, material: Material, report: Callable[[PalpateError], None] | None = None
) -> Path | None:
    """Find the best twin of a skin of this material in the folders of `results`; `None` if missing.

    Of several, one that states its material is preferred, then the smallest interpolation error, the maximum depth,
    and the first name of a folder; the time of a file does not matter.

    Parameters
    ----------
    results
        Folder of result folders.
    skin, material
        Of the design. A twin that does not state its material is accepted.
    report
        Called for every broken twin file, or one of another version, which is skipped.
    """
    found = []
    for path in sorted(twin_path(folder, skin) for folder in results.glob("*")):
        if path.is_file():
            try:
                twin = read_twin(path)
            except PalpateError as error:
                if report is not None:
                    report(error)
                continue
            if twin.skin.spec_data == skin.spec_data and twin.material in ("", material_text(material)):
                off = twin.interpolation_error_mm if np.isfinite(twin.interpolation_error_mm) else np.inf
                found.append(((not twin.material, off, -float(twin.depths_mm[-1])), path))
    return min(found)[1] if found else None


def material_text(material: Material) -> str:
    """Identity of a material as text, without its name."""
    return json.dumps(material.key_data(), sort_keys=True)


def twin_relaxation(twin: Twin) -> Relaxation | None:
    """Relaxation of a twin's material; `None` if it does not relax, or the twin does not state it.

    Raises
    ------
    PalpateError
        If gel and skin have different relaxations.
    """
    if not twin.material:
        return None
    data = json.loads(twin.material)
    if not any("relaxation" in part for part in (data, data.get("gel", {}))):
        return None
    return material_from_data({"name": "", **data}).whole_relaxation


def write_twin(path: Path, twin: Twin) -> None:
    """Write a twin.

    Raises
    ------
    PalpateError
        If the file cannot be written.
    """
    try:
        with create_hdf5(path) as file:
            file.attrs["kind"] = _KIND
            file.attrs["version"] = TWIN_VERSION
            file.attrs["skin"] = json.dumps(twin.skin.spec_data)
            file.attrs["material"] = twin.material
            file.attrs["made_by"] = json.dumps(provenance())
            file.attrs["interpolation_error_mm"] = twin.interpolation_error_mm
            file.attrs["left_out"] = json.dumps(twin.left_out)
            _write_branch(file, twin)
            if twin.inverted is not None:
                _write_branch(file.create_group(_INVERTED), twin.inverted)
    except OSError as error:
        raise PalpateError(
            f"{path} cannot be written: {error}.", "Choose another place.", code="file-unwritable"
        ) from None


def twin_version() -> str:
    """Return the version of a twin for its key: behaviour, libraries and file format."""
    return f"{stage_version('twin')}; format {TWIN_VERSION}"


def read_twin(path: Path) -> Twin:
    """Read a twin.

    Raises
    ------
    PalpateError
        If the file is not a twin of this version.
    """
    try:
        with h5py.File(path, "r") as file:
            reject_external_links(file, path)
            if file.attrs.get("kind") != _KIND:
                raise PalpateError(f"{path} is not a twin.", _AGAIN, code="twin-unreadable")
            if file.attrs["version"] != TWIN_VERSION:
                raise PalpateError(
                    f"{path} is a twin of version {file.attrs['version']}, this is {TWIN_VERSION}.",
                    _AGAIN,
                    code="twin-version",
                )
            twin = _read_branch(file, file.attrs)
            if _INVERTED in file:
                twin = replace(twin, inverted=_read_branch(file[_INVERTED], file.attrs))
    except (OSError, KeyError, ValueError, TypeError) as error:
        reason = "it is not an HDF5 file" if path.is_file() and not h5py.is_hdf5(path) else error
        raise PalpateError(f"{path} cannot be read as a twin: {reason}.", _AGAIN, code="twin-unreadable") from None
    for branch in (twin,) if twin.inverted is None else (twin, twin.inverted):
        _check(path, branch)
    return twin


def _write_branch(group: h5py.Group, twin: Twin) -> None:
    for name, unit in _ARRAYS.items():
        group.create_dataset(name, data=getattr(twin, name)).attrs["units"] = unit
    for name in ("amplitudes", "lateral"):
        data = getattr(twin, name).coefficients
        group.create_dataset(name, data=data).attrs["units"] = "mm, N, and over mm or degrees"
    for name, knots in zip(("inverse_friction", "tilt", "depth"), twin.amplitudes.knots, strict=True):
        group.create_dataset(f"knots/{name}", data=knots)


def _read_branch(group: h5py.Group, made: h5py.AttributeManager) -> Twin:
    knots = (group["knots/inverse_friction"][:], group["knots/tilt"][:], group["knots/depth"][:])
    return Twin(
        skin=build_skin(skin_from_data(json.loads(made["skin"]))),
        **{name: group[name][:] for name in _ARRAYS},
        amplitudes=TensorSpline(knots, group["amplitudes"][:]),
        lateral=TensorSpline(knots, group["lateral"][:]),
        material=str(made.get("material", "")),
        interpolation_error_mm=float(made.get("interpolation_error_mm", np.nan)),
        left_out=tuple(json.loads(made.get("left_out", "[]"))),
    )


def _check(path: Path, twin: Twin) -> None:
    """Reject a branch with invalid numbers."""
    if not all(
        np.isfinite(part).all() for part in (twin.modes, twin.amplitudes.coefficients, twin.lateral.coefficients)
    ):
        raise PalpateError(f"{path} contains values that are not finite.", _AGAIN, code="twin-not-finite")
    wanted = _PARTS * (len(twin.order) + FORCES)
    for name in ("amplitudes", "lateral"):
        count = getattr(twin, name).coefficients.shape[-1]
        if count != wanted:
            raise PalpateError(f"{path} has {count} {name}, not {wanted}.", _AGAIN, code="twin-count-wrong")
