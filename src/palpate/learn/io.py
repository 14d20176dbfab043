"""Estimators as HDF5: numbers and text only, so that opening a file runs nothing from it."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np

from palpate.core import PalpateError
from palpate.dataset import Normalisation
from palpate.learn.estimator import LEARN_VERSION, OUTPUTS, Estimator

KIND = "palpate estimator"


def write_estimator(path: Path, estimator: Estimator) -> None:
    """Write `estimator` to the HDF5 file `path`, replacing it."""
    with h5py.File(path, "w") as file:
        file.attrs["kind"] = KIND
        file.attrs["version"] = estimator.version
        file.attrs["activation"] = estimator.activation
        file.attrs["offset_px"] = estimator.normalisation.offset_px
        file.attrs["scale_px"] = estimator.normalisation.scale_px
        file.attrs["outputs"] = list(OUTPUTS)
        file.attrs["seed"] = estimator.seed
        file.attrs["made_by"] = json.dumps(dict(estimator.made_by))
        file.attrs["training_images"] = estimator.training_images
        file.attrs["validation_images"] = estimator.validation_images
        file.attrs["history"] = json.dumps(estimator.history)
        for name in ("output_mean", "output_sd", "rest_px"):
            file.create_dataset(name, data=getattr(estimator, name), track_times=False)
        file["rest_px"].attrs["units"] = "px"
        for number, (weight, bias) in enumerate(zip(estimator.weights, estimator.biases, strict=True)):
            file.create_dataset(f"layer_{number}/weight", data=weight, track_times=False)
            file.create_dataset(f"layer_{number}/bias", data=bias, track_times=False)


def read_estimator(path: Path) -> Estimator:
    """Read an estimator written by `write_estimator`.

    Raises
    ------
    PalpateError
        If the file is not an estimator, is of another version, or holds something that is not a number.
    """
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("kind") != KIND or file.attrs.get("version") != LEARN_VERSION:
                raise PalpateError(
                    f"{path} is not an estimator of version {LEARN_VERSION}.", "Train the estimator again."
                )
            estimator = _read(file)
    except (OSError, KeyError, ValueError) as error:
        raise PalpateError(f"{path} is not an estimator: {error}.", "Train the estimator again.") from error
    if not all(np.isfinite(part).all() for part in (*estimator.weights, *estimator.biases)):
        raise PalpateError(f"{path} holds a weight that is not a number.", "Train the estimator again.")
    return estimator


def _read(file: h5py.File) -> Estimator:
    layers = [file[f"layer_{number}"] for number in range(sum(name.startswith("layer_") for name in file))]
    offset, scale = (tuple(float(v) for v in file.attrs[name]) for name in ("offset_px", "scale_px"))
    return Estimator(
        normalisation=Normalisation((offset[0], offset[1]), (scale[0], scale[1])),
        weights=tuple(layer["weight"][...] for layer in layers),
        biases=tuple(layer["bias"][...] for layer in layers),
        activation=str(file.attrs["activation"]),
        output_mean=file["output_mean"][...],
        output_sd=file["output_sd"][...],
        rest_px=file["rest_px"][...],
        seed=int(file.attrs["seed"]),
        made_by=json.loads(file.attrs["made_by"]),
        training_images=int(file.attrs["training_images"]),
        validation_images=int(file.attrs["validation_images"]),
        history=tuple(tuple(errors) for errors in json.loads(file.attrs["history"])),
        version=str(file.attrs["version"]),
    )
