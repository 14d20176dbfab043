"""Where a built dome sits over its camera: the pose of least reprojection residual of one image at rest.

The six numbers of the camera's pose (offset, distance, two tilts, roll) are those for which the printed layout
projects onto the dots, by least squares with a loss that forgives misprints; the traces' centres are corrected for
the ellipse of a tilted disc. What is left over at each marker is its print error.

If wished, focal length and centre are refined with the pose. One image of one dome tells them apart only by the
dome's height: near dots are drawn larger than far ones (focal length against distance), and shift against them
(centre against tilt and offset). So they are held near the calibration, within `FOCAL_SD` and `CENTRE_SD_PX`, the
image moves them as far as it knows better, and their standard deviations say how far that is. The ratio of the two
focal lengths is left as calibrated, and so is the distortion but for the
coefficients that its `Lens` calls refinable.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial import cKDTree

from palpate.camera import LENSES, Camera, CameraSpec, build_camera, flat_marker_outlines, project_markers
from palpate.core import FloatArray, PalpateError
from palpate.design import MarkerLayout, Skin
from palpate.vision.assign_markers import MarkerAssignment
from palpate.vision.print_distortion import PrintDistortion, fit_print_distortion
from palpate.vision.rings import find_rings

_POSE = ("offset_x", "offset_y", "distance", "tilt_x_deg", "tilt_y_deg", "roll_deg")
_LEAST_MARKERS = 6
"""Markers that give a pose: twice the three that six numbers need."""
FOCAL_SD, CENTRE_SD_PX = 0.02, 5.0
"""What refining holds focal length (as a share) and centre to: how far the lens of another copy may be off."""
_EVEN = 0.05
"""Greatest residual over the distance of neighbours."""
_LEAST_BENT_PX, _BETTER = 0.5, 0.5
"""A print counts as bent where the pose alone leaves so many pixels, and the rings' law no more than this share."""
_MOST_BENT, _MOST_GROWN = 0.2, 0.13
"""Greatest departure of a ring's radius from the design's, and of the size of all: beyond, it is another design."""
_FORGIVEN_PX = 1.0
"""Distance beyond which a misprint no longer pulls with its square."""


@dataclass(frozen=True, eq=False)
class Registration:
    """The pose of a camera under a dome.

    Attributes
    ----------
    camera
        The camera where it is.
    rms_px
        Root of the mean squared distance of found dots from where they should be.
    reprojection_residual_px
        (m, 2) that distance for each marker; NaN where no dot was found.
    sd
        (6,) standard deviation of offset x, y (mm), distance (mm), tilts and roll (degrees).
    held_rms_px
        The same as `rms_px` with the lens as it was calibrated: what refining it gains.
    lens_sd
        (3 + k,) standard deviation of the focal length (share), of the centre (px) and of the lens' k refinable
        coefficients; NaN where they were held.
    distortion
        How the print is bent as a whole, where the pose alone does not explain the dots; else `None`.
    """

    camera: Camera
    rms_px: float
    reprojection_residual_px: FloatArray
    sd: FloatArray
    held_rms_px: float
    lens_sd: FloatArray
    distortion: PrintDistortion | None = None


@dataclass(frozen=True, eq=False)
class _Fit:
    camera: Camera
    left: FloatArray
    sd: FloatArray

    @property
    def rms_px(self) -> float:
        return float(np.sqrt(np.mean((self.left**2).sum(axis=1))))


def register_dome(
    naming: MarkerAssignment,
    layout: MarkerLayout,
    skin: Skin,
    nominal: CameraSpec | None = None,
    refine_lens: bool = False,
) -> Registration:
    """Find the pose of the camera from named markers at rest.

    Parameters
    ----------
    naming
        Markers and their dots.
    layout, skin
        What was printed, on what.
    nominal
        The lens, and about where the camera is.
    refine_lens
        Whether focal length and centre are fitted as well (the module says what an image at rest knows of them).

    Raises
    ------
    PalpateError
        If too few markers have a dot, the image is mirrored, or no pose with the dome before the camera fits.
    """
    nominal = nominal or CameraSpec()
    if naming.found.sum() < _LEAST_MARKERS:
        raise PalpateError(
            f"{naming.found.sum()} named markers do not give a pose, {_LEAST_MARKERS} are needed.",
            "Check the light.",
            code="pose-few-markers",
        )
    if naming.mirrored:
        raise PalpateError(
            "The image is mirrored: left is right.",
            "Flip it before it is read, or turn off the mirror.",
            code="image-mirrored",
        )
    points, seen = layout.positions[naming.found], naming.positions_px[naming.found]
    normals = skin.normal(points)
    edges = flat_marker_outlines(points, normals, layout.diameter)
    start = np.concatenate([[getattr(nominal, name) for name in _POSE], _lens_of(nominal)])
    start[5] = (start[5] - naming.turn_deg + 180.0) % 360.0 - 180.0
    about = _posed(nominal, start)
    where = points, seen, project_markers(about, edges).centres - about.project(points)
    held = fit = _fit(nominal, start, where)
    if refine_lens:
        fit = _fit(nominal, np.concatenate([_pose_of(held.camera), start[6:]]), where, held.rms_px / np.sqrt(2.0))
    spacing = float(np.median(cKDTree(seen).query(seen, 2)[0][:, 1]))
    law = None
    if fit.rms_px > _LEAST_BENT_PX:
        bent, law = _distort(fit, naming, (layout, skin), nominal, start)
        if law and (fit.rms_px > _EVEN * spacing or law.rms_px < _BETTER * fit.rms_px):
            fit = held = bent
        else:
            law = None
    if law and (law.rms_px > _EVEN * spacing or law.greatest > _MOST_BENT):
        raise PalpateError(
            f"The markers fit the design to {law.rms_px:.1f} px only, and that with rings {law.greatest:.0%} off.",
            "Check height, base radius and marker count, and the camera's focal length.",
            code="layout-misfit-rings",
        )
    if not law:
        _check_size(seen, build_camera(nominal).project(points), fit.rms_px)
    if not law and fit.rms_px > _EVEN * spacing:
        raise PalpateError(
            f"The markers fit the design to {fit.rms_px:.1f} px only.",
            "Check height, base radius and marker count, and the camera's focal length.",
            code="layout-misfit",
        )
    errors = np.full((len(layout), 2), np.nan)
    errors[naming.found] = -fit.left
    lens_sd = fit.sd[6:] if refine_lens else np.full(len(start) - 6, np.nan)
    return Registration(fit.camera, fit.rms_px, errors, fit.sd[:6], held.rms_px, lens_sd, law)


def _check_size(seen: FloatArray, expected: FloatArray, rms_px: float) -> None:
    """Refuse dots that are together so much larger or smaller than expected that the design is another one."""
    spread = [np.sqrt(((pixels - pixels.mean(axis=0)) ** 2).sum(axis=1).mean()) for pixels in (seen, expected)]
    scale = float(spread[0] / spread[1]) - 1.0
    if abs(scale) > _MOST_GROWN:
        raise PalpateError(
            f"The markers fit the design to {rms_px:.1f} px only where all of it is drawn {abs(scale):.0%} "
            f"too {'large' if scale > 0 else 'small'}.",
            "Check height, base radius and marker count, and the camera's focal length and distance.",
            code="layout-misfit-scale",
        )


def _distort(
    fit: _Fit, naming: MarkerAssignment, design: tuple[MarkerLayout, Skin], nominal: CameraSpec, start: FloatArray
) -> tuple[_Fit, PrintDistortion | None]:
    """The pose of a print that is bent as a whole, and its law; what a layout without rings keeps."""
    layout, skin = design
    rings = find_rings(layout.positions)
    if rings is None:
        return fit, None
    lens = start[6:]

    def posed(pose: FloatArray) -> Camera:
        return _posed(nominal, np.concatenate([pose, lens]))

    points = layout.positions[naming.found]
    edges = flat_marker_outlines(points, skin.normal(points), layout.diameter)
    bias = project_markers(fit.camera, edges).centres - fit.camera.project(points)
    which = np.flatnonzero(naming.found)
    seen = naming.positions_px[which] - bias
    pose, law = fit_print_distortion(rings, design, (which, seen), posed, (_pose_of(fit.camera), start[:6]))
    camera = posed(pose)
    left = camera.project(points) - seen
    return _Fit(camera, left, fit.sd), law


def _fit(
    nominal: CameraSpec, start: FloatArray, where: tuple[FloatArray, FloatArray, FloatArray], dot_px: float = 0.0
) -> _Fit:
    """Fit the pose to dots, and the lens as well where it is known how far dots are off; it counts as three more."""
    points, seen, bias = where
    free = len(start) if dot_px else len(_POSE)
    refined = np.array(list(LENSES.get(nominal.lens).refinable.values()))
    hold = dot_px / np.array([FOCAL_SD, CENTRE_SD_PX, CENTRE_SD_PX, *refined])

    def miss(values: FloatArray) -> FloatArray:
        every = np.concatenate([values, start[free:]])
        projected = _posed(nominal, every).project(points) + bias
        left = np.nan_to_num(projected - seen, nan=1e3).reshape(-1)
        held = hold * (values[6:] - _lens_of(nominal)) if free > len(_POSE) else np.empty(0)
        return np.concatenate([left, held])

    any_value = np.full(len(refined), np.inf)
    nearest = 1.0 + (nominal.window.thickness if nominal.window is not None else 0.0)
    low = np.array([-50.0, -50.0, nearest, -44.0, -44.0, -np.inf, 0.5, -np.inf, -np.inf, *-any_value])[:free]
    high = np.array([50.0, 50.0, 999.0, 44.0, 44.0, np.inf, 2.0, np.inf, np.inf, *any_value])[:free]
    scale = [1.0, 1.0, 1.0, 1.0, 1.0, 5.0, 0.01, 5.0, 5.0, *refined][:free]
    fit = least_squares(miss, start[:free], bounds=(low, high), loss="soft_l1", f_scale=_FORGIVEN_PX, x_scale=scale)
    left = miss(fit.x)[: seen.size].reshape(-1, 2)
    spread = np.linalg.pinv(fit.jac.T @ fit.jac) * 2.0 * fit.cost / max(left.size - 6, 1)
    camera = _posed(nominal, np.concatenate([fit.x, start[free:]]))
    return _Fit(camera, left, np.sqrt(np.diag(spread)))


def _pose_of(camera: Camera) -> FloatArray:
    return np.array([getattr(camera.spec, name) for name in _POSE])


def _lens_of(nominal: CameraSpec) -> FloatArray:
    """What refining starts from (3 + k,): factor on the focal lengths, centre in px, refinable coefficients."""
    lens = LENSES.get(nominal.lens)
    named = dict(zip(lens.parameters(), nominal.distortion, strict=True))
    return np.array([1.0, nominal.cx_px, nominal.cy_px, *(named[name] for name in lens.refinable)])


def _posed(nominal: CameraSpec, values: FloatArray) -> Camera:
    """The camera of a pose and of what `_lens_of` lists."""
    chosen: dict[str, Any] = dict(zip(_POSE, (float(value) for value in values[:6]), strict=True))
    chosen["roll_deg"] = (chosen["roll_deg"] + 180.0) % 360.0 - 180.0
    focal, column, row, *refined = (float(value) for value in values[6:])
    lens = LENSES.get(nominal.lens)
    named = dict(zip(lens.parameters(), nominal.distortion, strict=True)) | dict(
        zip(lens.refinable, refined, strict=True)
    )
    chosen["distortion"] = tuple(named.values())
    chosen |= {"fx_px": focal * nominal.fx_px, "fy_px": focal * nominal.fy_px, "cx_px": column, "cy_px": row}
    return build_camera(nominal.model_copy(update=chosen))
