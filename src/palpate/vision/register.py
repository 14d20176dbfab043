"""Registration of a built skin's camera: pose of minimum reprojection residual of a rest image.

The six parameters of the camera pose (offset, distance, two tilts, roll) minimise the distances of the projected
layout from the blobs, by least squares with a loss that is robust to misprints. The projected centres include the
bias of the ellipse of a tilted disc. The residual of each marker is its print error.

Optionally, focal length and centre are refined with the pose. One image of a skin separates them only by the skin's
height: near markers appear larger than distant ones (focal length against distance) and shift against them (centre
against tilt and offset). So they have priors at the calibration, of standard deviations `FOCAL_SD` and
`CENTRE_SD_PX`, and their standard deviations are returned. The ratio of the two focal lengths stays as calibrated, as
does the distortion except for the refinable coefficients of its `Lens`.
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
from palpate.vision.pattern import wrap_deg
from palpate.vision.print_distortion import PrintDistortion, fit_print_distortion
from palpate.vision.rings import find_rings

_POSE = ("offset_x", "offset_y", "distance", "tilt_x_deg", "tilt_y_deg", "roll_deg")
_LEAST_MARKERS = 6
"""Minimum number of markers for a pose: twice the three that six parameters need."""
FOCAL_SD, CENTRE_SD_PX = 0.02, 5.0
"""Prior standard deviations of refined focal length (relative) and centre: variation between lenses.
By hand."""
_EVEN = 0.05
"""Maximum residual over the distance of neighbours. By hand."""
_LEAST_BENT_PX, _BETTER = 0.5, 0.5
"""Distorted print: minimum residual (px) of the pose alone, maximum remaining share. By hand."""
_MOST_BENT, _MOST_GROWN = 0.2, 0.13
"""Maximum deviation of a ring's radius, and of the overall size, of the same design. By hand."""
_FORGIVEN_PX = 1.0
"""Distance beyond which the loss of a misprint is linear. By hand."""


@dataclass(frozen=True, eq=False)
class Registration:
    """Pose of a camera relative to the skin.

    Attributes
    ----------
    camera
        The camera at its fitted pose.
    rms_px
        Root mean square distance of the found blobs from their predictions.
    reprojection_residual_px
        (m, 2) residual of each marker; NaN without a blob.
    sd
        (6,) standard deviation of offset x, y (mm), distance (mm), tilts and roll (degrees).
    held_rms_px
        `rms_px` with the lens as calibrated, for comparison with a refined one.
    lens_sd
        (3 + k,) standard deviation of the focal length (relative), of the centre (px) and of the lens's k refinable
        coefficients; NaN if not refined.
    distortion
        Distortion of the whole print, if the pose alone does not explain the blobs; else `None`.
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
    """Fit the pose of the camera to the assigned markers of a rest image.

    Parameters
    ----------
    naming
        Markers and their blobs.
    layout, skin
        Design of the print.
    nominal
        The lens, and the approximate pose.
    refine_lens
        Whether focal length and centre are fitted as well (see the module).

    Raises
    ------
    PalpateError
        If too few markers have a blob, the image is mirrored, or no pose in front of the skin fits.
    """
    nominal = nominal or CameraSpec()
    if naming.found.sum() < _LEAST_MARKERS:
        raise PalpateError(
            f"{naming.found.sum()} assigned markers do not determine a pose, {_LEAST_MARKERS} are needed.",
            "Check the light.",
            code="pose-few-markers",
        )
    if naming.mirrored:
        raise PalpateError(
            "The image is mirrored.",
            "Flip it before it is read, or turn off the mirror.",
            code="image-mirrored",
        )
    points, seen = layout.positions[naming.found], naming.positions_px[naming.found]
    normals = skin.normal(points)
    edges = flat_marker_outlines(points, normals, layout.diameter)
    start = np.concatenate([[getattr(nominal, name) for name in _POSE], _lens_of(nominal)])
    start[5] = wrap_deg(start[5] - naming.turn_deg)
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
            f"The markers fit the design to {law.rms_px:.1f} px only, with ring radii wrong by {law.greatest:.0%}.",
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
    """Raise an error if all blobs together are so much larger or smaller that the design is another."""
    spread = [np.sqrt(((pixels - pixels.mean(axis=0)) ** 2).sum(axis=1).mean()) for pixels in (seen, expected)]
    scale = float(spread[0] / spread[1]) - 1.0
    if abs(scale) > _MOST_GROWN:
        raise PalpateError(
            f"The markers fit the design to {rms_px:.1f} px only, with an image that is {abs(scale):.0%} "
            f"too {'large' if scale > 0 else 'small'}.",
            "Check height, base radius and marker count, and the camera's focal length and distance.",
            code="layout-misfit-scale",
        )


def _distort(
    fit: _Fit, naming: MarkerAssignment, design: tuple[MarkerLayout, Skin], nominal: CameraSpec, start: FloatArray
) -> tuple[_Fit, PrintDistortion | None]:
    """Fit the pose of a distorted print, and its distortion; without rings, keep the fit."""
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
    """Fit the pose to blobs; with a blob error `dot_px`, fit the lens as well."""
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
    """Return the initial lens parameters (3 + k,): focal factor, centre in px, refinable coefficients."""
    lens = LENSES.get(nominal.lens)
    named = dict(zip(lens.parameters(), nominal.distortion, strict=True))
    return np.array([1.0, nominal.cx_px, nominal.cy_px, *(named[name] for name in lens.refinable)])


def _posed(nominal: CameraSpec, values: FloatArray) -> Camera:
    """Return the camera of a pose and of the parameters listed in `_lens_of`."""
    chosen: dict[str, Any] = dict(zip(_POSE, (float(value) for value in values[:6]), strict=True))
    chosen["roll_deg"] = wrap_deg(chosen["roll_deg"])
    focal, column, row, *refined = (float(value) for value in values[6:])
    lens = LENSES.get(nominal.lens)
    named = dict(zip(lens.parameters(), nominal.distortion, strict=True)) | dict(
        zip(lens.refinable, refined, strict=True)
    )
    chosen["distortion"] = tuple(named.values())
    chosen |= {"fx_px": focal * nominal.fx_px, "fy_px": focal * nominal.fy_px, "cx_px": column, "cy_px": row}
    return build_camera(nominal.model_copy(update=chosen))
