"""The noun of the stage: clean images of markers with the poses that made them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, TextArray
from palpate.datasets.normalise import Normalisation
from palpate.datasets.spec import DatasetSpec
from palpate.datasets.split import check_leakage
from palpate.design import TILT_SPACE, PoseSpace


@dataclass(frozen=True)
class Dataset:
    """Images of one design, without jitter, which is drawn again at each use.

    The order of the markers is that of the layout, in every image. An image in which a marker cannot be seen
    is not in the dataset, since a network that reads every marker has no input for it; `dropped` counts it.

    Attributes
    ----------
    spec
        Sampling of poses and images.
    images_px
        (n, m, 2) u and v of each marker (px).
    poses
        (n, 3) by `space`: rx and ry (degrees), depth (mm).
    press
        (n,) number of the virtual press: one pose with all its depths.
    validation
        (n,) whether the image is held out; all images of a press are on one side.
    branch
        (n,) ``"flat"`` or ``"inverted"``.
    travel_mm
        (n,) mean over the markers of their distance from rest in space (mm).
    rest_px
        (m, 2) markers of the undeformed dome (px).
    image_size_px
        Width and height of the image (px).
    solved_presses
        Solved presses behind the images.
    dropped
        Sampled images left out, by reason.
    space
        Coordinates of the poses, by the obstacle.
    forces
        (n, 3) N of the skin on the wall, in the skin's frame; `None` if not requested.
    """

    spec: DatasetSpec
    images_px: FloatArray
    poses: FloatArray
    press: IntArray
    validation: BoolArray
    branch: TextArray
    travel_mm: FloatArray
    rest_px: FloatArray
    image_size_px: tuple[int, int]
    solved_presses: int
    dropped: Mapping[str, int]
    space: PoseSpace = TILT_SPACE
    forces: FloatArray | None = None

    def __post_init__(self) -> None:
        count = len(self.images_px)
        columns = (self.poses, self.press, self.validation, self.branch, self.travel_mm)
        lengths = {len(column) for column in columns}
        if lengths != {count}:
            raise PalpateError(
                f"A dataset of {count} images has columns of {sorted(lengths)} rows.", code="dataset-column-lengths"
            )
        if not np.isfinite(self.images_px).all():
            raise PalpateError(
                "A dataset has a marker whose position is not a number.",
                "Make the dataset again.",
                code="dataset-not-finite",
            )
        check_leakage(self.press, self.poses, self.validation, self.space)

    @property
    def normalisation(self) -> Normalisation:
        """Map from pixels to the numbers a network reads."""
        return Normalisation.of_image(self.spec.normalisation, *self.image_size_px)

    @property
    def virtual_presses(self) -> int:
        """Number of sampled poses that gave at least one image."""
        return len(np.unique(self.press))

    def full_depth_travel_mm(self) -> float:
        """Mean marker travel of the design: `travel_mm` averaged over the images at the maximum depth."""
        deepest = self.poses[:, 2].max()
        return float(self.travel_mm[np.isclose(self.poses[:, 2], deepest)].mean())

    def subset(self, *, validation: bool) -> Self:
        """The held-out images, or those for training, as a dataset of their own."""
        return self.select(self.validation == validation, validation=validation)

    def select(self, rows: BoolArray, *, validation: bool) -> Self:
        """Images (n,), all for training or all held out, as a dataset of their own."""
        return replace(
            self,
            images_px=self.images_px[rows],
            poses=self.poses[rows],
            press=self.press[rows],
            validation=np.full(int(rows.sum()), validation),
            branch=self.branch[rows],
            travel_mm=self.travel_mm[rows],
            forces=None if self.forces is None else self.forces[rows],
        )
