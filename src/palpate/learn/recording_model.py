"""Model of a recording: layout, estimators and intervals in one HDF5 file of numbers, without code.

An image is preprocessed as in the training, its blobs are assigned to the layout, and the estimator of minimum
held-out error gives the pose. If the assignment is not accepted, the best estimator on images is used instead, with
its own, wider intervals.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from palpate.core import (
    BoolArray,
    FloatArray,
    IntArray,
    PalpateError,
    atomic_write,
    create_hdf5,
    reject_external_links,
)
from palpate.design import TILT_SPACE, PoseSpace
from palpate.learn.ensemble import Ensemble
from palpate.learn.error_scale import ErrorScale, image_features
from palpate.learn.interval import Prediction
from palpate.learn.member import EnsembleMember, open_member
from palpate.learn.preprocess import Preprocessor
from palpate.vision import Correspondence, Detector, DetectSpec, MarkerMatcher, MatchFault, ObservedLayout

FORMAT, FORMAT_VERSION = "palpate-recorded-model", 4
"""Name and version in the header of a model."""
_READ = (3, FORMAT_VERSION)
"""Versions that can be read; files of version 3 have one half-width for all images."""
BANK = 200
"""Images that a model keeps as initial guesses of assignments. By hand."""
_BEYOND = 0.5
"""Distance beyond the training poses to which estimates are limited, over their range. By hand."""
_STORED = ("fields", "seen", "motion", "usual")


@dataclass(frozen=True, eq=False)
class RecordedModel:
    """Sensor model trained on a recording.

    Attributes
    ----------
    preprocessor
        Preprocessing of images.
    layout
        Markers at rest; `None` for a sensor with image estimators only.
    reference_bank
        Displacements (b, m, 2) and descriptors of their images (b, GRID²) as initial guesses of assignments, with
        motion modes and usual residuals, see `MarkerMatcher.to_arrays`.
    parts
        All estimators of the model, by name.
    marker_ensemble, image_ensemble
        Estimators of images with and without assigned markers; `None` if missing.
    max_disagreement
        (k,) maximum difference of the two ensembles for an accepted assignment; infinite if a limit does not help.
    outputs
        Axis and unit of each component, and its name in the table.
    about
        Inputs and versions of its making, as JSON data.
    """

    preprocessor: Preprocessor
    layout: ObservedLayout | None
    reference_bank: tuple[FloatArray, FloatArray, FloatArray, FloatArray]
    parts: Mapping[str, EnsembleMember]
    marker_ensemble: Ensemble | None
    image_ensemble: Ensemble | None
    max_disagreement: FloatArray
    outputs: tuple[tuple[str, str, str], ...]
    about: Mapping[str, Any]

    @property
    def space(self) -> PoseSpace:
        """Estimated components; the package's own space for the pose of a wall."""
        names = tuple(f"{axis}_{unit}" for axis, unit, _ in self.outputs)
        if names == TILT_SPACE.names:
            return TILT_SPACE
        return PoseSpace.from_axes([(axis, unit) for axis, unit, _ in self.outputs])

    @cached_property
    def matcher(self) -> MarkerMatcher | None:
        """Matcher that assigns blobs to markers."""
        if self.layout is None:
            return None
        fields, seen, motion, usual = self.reference_bank
        return MarkerMatcher(self.layout, self.preprocessor.shape, list(seen), list(fields)).with_arrays(
            motion, usual
        )

    def read(self, image: NDArray[Any]) -> tuple[Prediction, Correspondence | None]:
        """Estimate the pose in one image.

        Parameters
        ----------
        image
            (h, w) or (h, w, 3), of the size of the recording.

        Returns
        -------
        tuple[Prediction, Correspondence | None]
            One estimate, out of distribution if the displacement of the markers is far from all of the training, and
            the assignment of the markers; `None` for a sensor with image estimators only.

        Raises
        ------
        PalpateError
            If it is not an image, or has another size.
        """
        picture, dots = self.preprocessor.extract(image)
        found = self.matcher.find(dots) if self.matcher is not None else None
        count = 0 if found is None else int(found.found.sum())
        moved: FloatArray = np.zeros((1, 0, 2)) if found is None else found.moved_px[None]
        good = np.array([found is not None and found.accepted])
        estimates = self.estimate_parts(moved, picture[None], good)
        poses, by_dots = self.combine(estimates, good)
        use = self.marker_ensemble if by_dots[0] else self.image_ensemble
        width, far = np.full(poses.shape, np.inf), np.zeros(1, bool)
        if use is not None:
            width = use.half_widths(self.features(use, estimates, moved, np.array([moved.shape[1] - count])))
            far[0] = good[0] and self.nearest_px(moved)[0] > self.reach_px
        if found is not None and good[0] and self.marker_ensemble is not None and not by_dots[0]:
            found = replace(found, fault=MatchFault.PICTURE)
        return Prediction(poses, width, far, space=self.space), found

    def features(
        self, use: Ensemble, estimates: Mapping[str, FloatArray], moved: FloatArray, missing: IntArray
    ) -> FloatArray:
        """Features (n, f) of images for the intervals of an ensemble; NaN if it cannot read an image.

        Parameters
        ----------
        use, estimates
            The ensemble, and the estimates (n, k) of each part.
        moved, missing
            (n, m, 2) displacements, and (n,) number of markers that were not found.
        """
        nearest, lost = np.zeros(len(missing)), np.zeros(len(missing))
        if any(self.parts[name].reads_markers for name in use.parts):
            nearest, lost = self.nearest_px(moved), np.asarray(missing, float)
        low, high = np.array(self.about["range"])
        return image_features(use.combine(estimates), low, high, lost, nearest, use.spread(estimates))

    def nearest_px(self, moved: FloatArray) -> FloatArray:
        """RMS distance (n,) of displacements (n, m, 2) from the nearest of the bank, px."""
        bank, fields = self.reference_bank[0], moved.reshape(len(moved), -1)
        if not bank.size:
            return np.zeros(len(moved))
        flat = bank.reshape(len(bank), -1)
        return np.sqrt([np.mean((flat - field) ** 2, axis=1).min() for field in fields])

    @cached_property
    def reach_px(self) -> float:
        """Largest accepted distance from the bank, px: twice the largest within the bank."""
        bank = self.reference_bank[0].reshape(len(self.reference_bank[0]), -1)
        if len(bank) < 2:
            return np.inf
        apart = [np.sort(np.mean((bank - field) ** 2, axis=1))[1] for field in bank]
        return float(2.0 * np.sqrt(max(apart)))

    def estimate_parts(self, moved: FloatArray, pictures: NDArray[Any], good: BoolArray) -> dict[str, FloatArray]:
        """Estimates (n, k) of each part for the images that it decides on, else NaN.

        Parameters
        ----------
        moved, pictures, good
            (n, m, 2) displacements, (n, h, w) small images and (n,) whether the assignment is accepted.
        """
        estimates = {}
        by_picture = ~good | np.isfinite(self.max_disagreement).any() | (self.marker_ensemble is None)
        for name, part in self.parts.items():
            used = self.marker_ensemble is not None and name in self.marker_ensemble.parts
            rows = good & used if part.reads_markers else (good & used) | by_picture
            estimates[name] = np.full((len(good), len(self.outputs)), np.nan)
            if rows.any():
                estimates[name][rows] = part.predict((moved if part.reads_markers else pictures)[rows])
        return estimates

    def combine(self, estimates: Mapping[str, FloatArray], good: BoolArray) -> tuple[FloatArray, BoolArray]:
        """Poses (n, k) from the estimates (n, k) of each part, NaN if impossible, and (n,) whether by markers."""
        found = np.full((len(good), len(self.outputs)), np.nan)
        by_dots = good.copy() if self.marker_ensemble is not None else np.zeros(len(good), bool)
        if self.marker_ensemble is not None:
            found[good] = self.marker_ensemble.combine(estimates)[good]
        if self.image_ensemble is not None:
            other = self.image_ensemble.combine(estimates)
            by_dots &= ~(np.abs(found - other) > self.max_disagreement).any(axis=1)
            found[~by_dots] = other[~by_dots]
        return self._bounded(found), by_dots

    def _bounded(self, poses: FloatArray) -> FloatArray:
        """Poses within the trained range and half of its width beyond: a linear estimator knows no limit."""
        low, high = np.array(self.about["range"])
        return np.clip(poses, low - _BEYOND * (high - low), high + _BEYOND * (high - low))

    def is_outside(self, pose: FloatArray, half_width: FloatArray) -> bool:
        """Whether a pose (k,) is beyond the training poses by more than its interval (k,)."""
        low, high = np.array(self.about["range"])
        room = np.minimum(half_width, 0.9 * _BEYOND * (high - low))
        return bool(((pose < low - room) | (pose > high + room)).any())


def write_model(path: Path, model: RecordedModel) -> None:
    """Write a model.

    Raises
    ------
    PalpateError
        If the file cannot be written.
    """
    with atomic_write(path) as draft, create_hdf5(draft) as file:
        file.attrs["format"], file.attrs["format_version"] = FORMAT, FORMAT_VERSION
        detector = model.preprocessor.detector
        file.attrs["about"] = json.dumps(
            {
                "shape": model.preprocessor.shape,
                "size": model.preprocessor.size,
                "dark": model.preprocessor.dark,
                "detector": None if detector is None else [detector.dark, detector.diameter_px, detector.edge_px],
                "outputs": model.outputs,
                "with_dots": _plain(model.marker_ensemble),
                "without": _plain(model.image_ensemble),
                "apart": [None if np.isinf(value) else value for value in model.max_disagreement.tolist()],
                "parts": [[name, part.kind] for name, part in model.parts.items()],
                "about": model.about,
            }
        )
        if model.layout is not None:
            file["rest_px"] = model.layout.rest_px
            file["fields"] = np.asarray(model.reference_bank[0][:BANK], np.float32)
            file["seen"] = np.asarray(model.reference_bank[1][:BANK], np.float32)
            file["motion"], file["usual"] = np.asarray(model.reference_bank[2], np.float32), model.reference_bank[3]
        for name, part in model.parts.items():
            for key, values in part.arrays.items():
                single = np.asarray(values)
                file[f"parts/{name}/{key}"] = (
                    single.astype(np.float32) if single.dtype == float and single.ndim > 1 else single
                )


def read_model(path: Path) -> RecordedModel:
    """Read a model written by `write_model`.

    Raises
    ------
    PalpateError
        If the file is not such a model.
    """
    again = "Make it again by palpate recording train."
    try:
        with h5py.File(path, "r") as file:
            reject_external_links(file, path)
            version = int(file.attrs.get("format_version", 0))
            if file.attrs.get("format") != FORMAT or version not in _READ:
                raise PalpateError(f"{path} is no model of format {FORMAT_VERSION}.", again, code="model-version")
            facts = json.loads(file.attrs["about"])
            parts = {
                name: open_member(kind, name, {key: np.asarray(item) for key, item in file[f"parts/{name}"].items()})
                for name, kind in facts["parts"]
            }
            layout = ObservedLayout(np.asarray(file["rest_px"])) if "rest_px" in file else None
            kept = [np.asarray(file[name]) if layout else np.zeros(0) for name in _STORED]
        found = facts["detector"]
        detector = (
            None
            if found is None
            else Detector(DetectSpec(mask="none"), bool(found[0]), found[1], None, found[2], drop_strays=True)
        )
        eye = Preprocessor(tuple(facts["shape"]), detector, tuple(facts["size"]), bool(facts["dark"]))
        return RecordedModel(
            eye,
            layout,
            (kept[0], kept[1], kept[2], kept[3]),
            parts,
            _choosing(facts["with_dots"]),
            _choosing(facts["without"]),
            np.array([np.inf if value is None else value for value in facts["apart"]]),
            tuple((str(axis), str(unit), str(column)) for axis, unit, column in facts["outputs"]),
            facts["about"],
        )
    except (OSError, KeyError, ValueError, TypeError, IndexError) as error:
        raise PalpateError(
            f"{path} is not a model of a recording: {error}.", again, code="model-unreadable"
        ) from error


def is_recorded_model(path: Path) -> bool:
    """Whether a file is marked as such a model."""
    try:
        with h5py.File(path, "r") as file:
            return bool(file.attrs.get("format") == FORMAT)
    except OSError:
        return False


def _plain(use: Ensemble | None) -> Any:
    if use is None:
        return None
    scale = None if use.scale is None else use.scale.to_lists()
    return [list(use.parts), use.weights.tolist(), use.half_width.tolist(), scale]


def _choosing(found: Any) -> Ensemble | None:
    if found is None:
        return None
    scale = ErrorScale.from_lists(found[3]) if len(found) > 3 and found[3] is not None else None
    return Ensemble(tuple(found[0]), np.array(found[1]), np.array(found[2], float), scale=scale)
