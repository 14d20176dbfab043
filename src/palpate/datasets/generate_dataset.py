"""Datasets from solved presses: sampled poses, interpolated and projected markers, split by press."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Camera
from palpate.core import FloatArray, PalpateError
from palpate.datasets.dataset import Dataset
from palpate.datasets.poses import sample_poses
from palpate.datasets.randomise import PerturbedPresses, RandomisedField, randomise_camera, randomise_field
from palpate.datasets.spec import DatasetSpec
from palpate.datasets.split import number_presses, split_presses
from palpate.design import MarkerLayout, Skin
from palpate.fea import Press

UNSEEN = "a marker out of sight"


def generate_dataset(
    presses: Sequence[Press],
    markers: MarkerLayout,
    camera: Camera,
    spec: DatasetSpec = DatasetSpec(),  # noqa: B008  (a spec is frozen)
    perturbed_presses: PerturbedPresses = PerturbedPresses(),  # noqa: B008  (frozen as well)
    forces: bool = False,
) -> Dataset:
    """Make the images of one design.

    Parameters
    ----------
    presses
        Solved presses of one skin by one kind of obstacle, one a tilt or offset. Offsets are sampled as
        far as these go.
    markers
        Layout on the dome's inner surface.
    camera
        Camera below the markers.
    spec
        Poses, images left out, jitter, normalisation, split and deviations of units.
    perturbed_presses
        Presses of deviating units, as `spec.randomise` requires.
    forces
        Whether the images have the force on the wall as well.

    Returns
    -------
    Dataset
        Clean images, and the number of sampled images left out by reason.

    Raises
    ------
    PalpateError
        If a marker at rest cannot be seen, no image is left, or presses that `spec.randomise` asks for are missing.

    Examples
    --------
    >>> from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
    >>> from palpate.fea import WallSpec, solve_press
    >>> from palpate.material import get_material
    >>> from palpate.mesh import MeshSpec, mesh_skin
    >>> skin = build_skin(DomeSpec())
    >>> mesh, law = mesh_skin(skin, MeshSpec(cells=4)), get_material("zaid_2024_ecoflex_00_30")
    >>> walls = [WallSpec(tilt_deg=tilt, depth=2.4, contact="frictionless") for tilt in (0, 6)]
    >>> presses = [solve_press(mesh, law, wall) for wall in walls]
    >>> from palpate.camera import build_camera
    >>> spec = DatasetSpec(n_presses=50, max_tilt_deg=6)
    >>> dataset = generate_dataset(presses, place_markers(skin, MarkerSpec(count=7)), build_camera(), spec)
    >>> dataset.images_px.shape, dataset.virtual_presses, int(dataset.validation.sum())
    ((50, 7, 2), 50, 10)
    """
    if forces:
        _refuse_forces(presses)
    field = randomise_field(presses, markers, perturbed_presses, spec)
    base = field.base
    rotations = sample_poses(spec, base.max_offset, lies=base.space.is_line, min_tilt_deg=base.min_tilt_deg)
    view = _View(camera, presses[0].mesh.skin, spec, base.rest)
    _refuse_unseen_at_rest(base.rest, view)
    number = number_presses(rotations)
    dropped: Counter[str] = Counter()
    images = range(spec.dropped_images, len(base.depths_mm))
    columns = [_images_at(field, image, rotations, view, dropped) for image in images]
    if forces:
        for column, image in zip(columns, images, strict=True):
            column["forces"] = field.forces(rotations, np.asarray(column["row"], np.intp), image)
    if not columns or not sum(len(column["row"]) for column in columns):
        raise PalpateError(
            f"No image is left: {spec.dropped_images} images dropped, presses end at "
            f"{base.depths_mm.max(initial=0.0):g} mm, {sum(dropped.values())} images out of reach.",
            "Press deeper, or drop fewer images.",
            code="dataset-no-image",
        )
    joined = {name: np.concatenate([column[name] for column in columns]) for name in columns[0]}
    press = number[joined["row"]]
    return Dataset(
        spec=spec,
        images_px=joined["images_px"],
        poses=base.space.poses(rotations[joined["row"]], joined["depth"]),
        press=press,
        validation=split_presses(press, spec.seed, spec.validation_fraction).validation,
        branch=joined["branch"],
        travel_mm=joined["travel_mm"],
        rest_px=camera.project(base.rest),
        image_size_px=(camera.width_px, camera.height_px),
        solved_presses=len(presses) + perturbed_presses.count,
        dropped=dict(dropped),
        space=base.space,
        forces=joined.get("forces"),
    )


@dataclass(frozen=True)
class _View:
    """A camera under the dome whose clamped rim may hide a marker."""

    camera: Camera
    skin: Skin
    spec: DatasetSpec
    rest: FloatArray

    def project(self, points: FloatArray, rest: FloatArray, rows: NDArray[np.intp]) -> FloatArray:
        """(k, m, 2) px of markers (k, m, 3) of the virtual presses `rows`, as if each rest looked as designed."""
        varied = self.spec.randomise
        if varied is None or not (varied.varies_camera or varied.dot):
            return self.camera.project(points)
        moved = np.empty((*points.shape[:2], 2))
        for k, row in enumerate(rows):
            camera = (
                randomise_camera(self.camera, varied, self.spec.seed, int(row))
                if varied.varies_camera
                else self.camera
            )
            moved[k] = camera.project(points[k]) - camera.project(rest[k])
        return self.camera.project(self.rest) + moved


def _images_at(
    field: RandomisedField, image: int, rotations: FloatArray, view: _View, dropped: Counter[str]
) -> dict[str, NDArray[np.generic]]:
    """Return the columns of the images at one depth; `dropped` counts the rejected images."""
    branch, reason = field.labels(rotations, image)
    dropped.update(str(text) for text in reason[reason != ""])
    row = np.flatnonzero(branch != "")
    points = field.positions(rotations, row, image)
    seen = view.camera.visible(points, view.skin).all(axis=1)
    if not seen.all():
        dropped[UNSEEN] += int((~seen).sum())
    row, points = row[seen], points[seen]
    rest = field.rest_of(row)
    return {
        "row": row,
        "images_px": view.project(points, rest, row),
        "depth": np.full(len(row), field.base.depths_mm[image]),
        "branch": branch[row],
        "travel_mm": np.linalg.norm(points - rest, axis=-1).mean(axis=-1),
    }


def _refuse_forces(presses: Sequence[Press]) -> None:
    if not all(press.obstacle.pose_space.is_tilt for press in presses):
        raise PalpateError(
            "Forces are interpolated under walls.", "Read those of single presses instead.", code="forces-need-wall"
        )
    for press in presses:
        press.mesh.skin.require_revolution(
            "its forces are not interpolated",
            "Read those of single presses; leave `forces` out.",
            code="forces-need-revolution",
        )


def _refuse_unseen_at_rest(rest: FloatArray, view: _View) -> None:
    unseen = np.flatnonzero(~view.camera.visible(rest, view.skin))
    if len(unseen):
        shown = ", ".join(str(number) for number in unseen[:5])
        raise PalpateError(
            f"{len(unseen)} of {len(rest)} markers cannot be seen at rest (numbers {shown}).",
            "Increase the distance of the camera, or use smaller rings.",
            code="markers-hidden",
        )
