"""Datasets as HDF5 with dimension scales: ``xarray.open_dataset(path, engine="h5netcdf")`` opens them."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from palpate.camera import Camera
from palpate.core import PalpateError, create_hdf5, reject_external_links, stage_version
from palpate.datasets.dataset import Dataset
from palpate.datasets.spec import DatasetSpec
from palpate.design import PoseSpace

DATASET_FORMAT = "1"
"""Version of the file format; files of another one are refused."""
_COLUMNS = {
    "images_px": (("image", "marker", "pixel_axis"), "px", "clean marker positions"),
    "poses": (("image", "pose_axis"), "deg, deg, mm", "rotation of the wall and depth"),
    "press": (("image",), "1", "number of the virtual press"),
    "validation": (("image",), "1", "1 where the image is held out"),
    "branch": (("image",), "1", "flat or inverted"),
    "travel_mm": (("image",), "mm", "mean distance of the markers from rest"),
    "rest_px": (("marker", "pixel_axis"), "px", "markers of the undeformed dome"),
}


def dataset_version(camera: Camera) -> str:
    """Return the version of a dataset for its key: behaviour, libraries, lens plug-in, file format."""
    return f"{stage_version('dataset', camera.lens)}; format {DATASET_FORMAT}"


def write_dataset(path: Path, dataset: Dataset) -> None:
    """Write `dataset` to the HDF5 file `path`, replacing it."""
    with create_hdf5(path) as file:
        file.attrs["palpate_dataset_version"] = DATASET_FORMAT
        file.attrs["spec"] = dataset.spec.model_dump_json()
        file.attrs["image_size_px"] = np.array(dataset.image_size_px)
        file.attrs["solved_presses"] = dataset.solved_presses
        file.attrs["dropped"] = json.dumps(dict(dataset.dropped))
        images, markers = dataset.images_px.shape[:2]
        _write_dimension(file, "image", np.arange(images))
        _write_dimension(file, "marker", np.arange(markers))
        for name, labels in {"pixel_axis": ("u_px", "v_px"), "pose_axis": dataset.space.names}.items():
            _write_dimension(file, name, np.array(labels, dtype=h5py.string_dtype()))
        for name, (dimensions, unit, meaning) in _COLUMNS.items():
            column = file.create_dataset(name, data=_storable(getattr(dataset, name)), track_times=False)
            if name == "poses" and not dataset.space.is_tilt:
                unit = ", ".join(item.unit for item in dataset.space.components)
                meaning = "place of the obstacle and depth" + (", direction" if dataset.space.is_line else "")
            column.attrs["units"] = unit
            column.attrs["long_name"] = meaning
            for axis, dimension in enumerate(dimensions):
                column.dims[axis].attach_scale(file[dimension])


def read_dataset(path: Path) -> Dataset:
    """Read a dataset written by `write_dataset`.

    Raises
    ------
    PalpateError
        If the file is not a dataset, or was written by another version.
    """
    try:
        with h5py.File(path, "r") as file:
            reject_external_links(file, path)
            version = file.attrs.get("palpate_dataset_version")
            if version != DATASET_FORMAT:
                raise PalpateError(
                    f"{path} holds dataset version {version}, this program reads version {DATASET_FORMAT}.",
                    "Make the dataset again.",
                    code="dataset-version",
                )
            return _read(file)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise PalpateError(
            f"{path} is not a dataset: {error}.", "Make the dataset again.", code="dataset-unreadable"
        ) from error


def _read(file: h5py.File) -> Dataset:
    width, height = (int(value) for value in file.attrs["image_size_px"])
    return Dataset(
        spec=DatasetSpec.model_validate_json(file.attrs["spec"]),
        images_px=file["images_px"][...],
        poses=file["poses"][...],
        press=file["press"][...],
        validation=file["validation"][...].astype(bool),
        branch=file["branch"].asstr()[...].astype(str),
        travel_mm=file["travel_mm"][...],
        rest_px=file["rest_px"][...],
        image_size_px=(width, height),
        solved_presses=int(file.attrs["solved_presses"]),
        dropped=json.loads(file.attrs["dropped"]),
        space=PoseSpace.from_names(file["pose_axis"].asstr()[...]),
    )


def _storable(column: NDArray[np.generic]) -> NDArray[np.generic]:
    if column.dtype.kind == "U":
        return column.astype(h5py.string_dtype())
    return column.astype(np.uint8) if column.dtype == bool else column


def _write_dimension(file: h5py.File, name: str, values: NDArray[np.generic]) -> None:
    file.create_dataset(name, data=values, track_times=False).make_scale(name)
