"""Reference press: a press of known pose that resolves the symmetry of a layout without a mark."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.camera import CameraSpec, build_camera
from palpate.core import FloatArray, PalpateError
from palpate.design import Design
from palpate.fea import WallSpec, solve_press
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor.unit import Unit
from palpate.vision import MarkerAssignment, PressFit, disambiguate_by_press, register_dome

_CELLS = 10
"""Cells of a coarse mesh, solved in seconds; its error is below that of the unknown friction. By hand."""
_IMAGE_STEP = 0.5
"""Depth step of the press, mm. By hand."""


@dataclass(frozen=True, eq=False)
class ReferencePress:
    """Image (h, w) or (h, w, 3) of a press of known pose, and positions (m, 3) mm of its markers.

    The camera is that of the rest image, unmoved; the positions are simulated.
    """

    image: NDArray[Any]
    positions: FloatArray

    @classmethod
    def simulate(cls, image: NDArray[Any], pose: tuple[float, float, float], design: Design) -> Self:
        """Simulate the press of an image.

        Parameters
        ----------
        image
            The image of the press.
        pose
            rx, ry (degrees) and depth (mm) of the wall, by a robot or a wedge; a depth error of 1 mm is harmless.
        design
            The design.

        Raises
        ------
        PalpateError
            If the depth is not positive, or the simulated press ends before it.
        """
        rx, ry, depth = pose
        if not depth > 0.0:
            raise PalpateError(
                f"The press depth is {depth:g} mm; it must be positive.",
                "Give a depth such as 4 mm.",
                code="press-depth-not-positive",
            )
        wall = WallSpec(
            tilt_deg=float(np.hypot(rx, ry)),
            azimuth_deg=float(np.degrees(np.arctan2(ry, rx))) % 360.0,
            depth=depth,
            depth_step=min(_IMAGE_STEP, depth),
        )
        mesh = mesh_skin(design.skin, MeshSpec(cells=_CELLS, filled=design.material.has_gel))
        press = solve_press(mesh, design.material, wall)
        if press.depth[-1] < depth - 1e-6:
            raise PalpateError(
                f"The simulated press ends at {press.depth[-1]:.1f} of {depth:g} mm: {press.ended}.",
                "Use a smaller depth.",
                code="press-ends-early",
            )
        return cls(image, press.positions(design.layout.positions)[-1])


def disambiguate(naming: MarkerAssignment, pressed_px: FloatArray, positions: FloatArray, unit: Unit) -> PressFit:
    """Choose among the assignments of a rest image by the blobs (n, 2) of a reference press.

    Each assignment implies another camera pose, from which the markers at `positions` (m, 3) are predicted.

    Raises
    ------
    PalpateError
        If an assignment cannot be registered, or `palpate.vision.disambiguate_by_press` fails.
    """
    nominal = unit.camera_spec
    choices = (naming, *naming.alternatives)
    motions = np.stack([_motion(choice, positions, unit, nominal) for choice in choices])
    rest = build_camera(nominal).project(unit.design.layout.positions)
    spacing = float(cKDTree(rest).query(rest, 2)[0][:, 1].min())
    return disambiguate_by_press(naming, motions, pressed_px, spacing)


def _motion(choice: MarkerAssignment, positions: FloatArray, unit: Unit, nominal: CameraSpec) -> FloatArray:
    """Return the motion (m, 2) px of the markers under one assignment; a mirrored image is flipped first."""
    flip = np.array([-1.0 if choice.mirrored else 1.0, 1.0])
    if choice.mirrored:
        width = nominal.width_px - 1.0
        seen = choice.positions_px * flip + [width, 0.0]
        choice = replace(choice, positions_px=seen, mirrored=False, turn_deg=180.0 - choice.turn_deg)
        lens = build_camera(nominal).lens.mirrored().coefficients
        nominal = nominal.model_copy(update={"cx_px": width - nominal.cx_px, "distortion": lens})
    camera = register_dome(choice, unit.design.layout, unit.design.skin, nominal).camera
    return np.asarray((camera.project(positions) - camera.project(unit.design.layout.positions)) * flip)
