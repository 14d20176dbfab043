"""Sensor asset for rigid-body simulators: skin with mass, contact spring, and camera with its frames.

Units are those of REP 103: m, kg, s, N, rad. The root frame is the sensor's of the docs (*Mount it*): its origin is
the centre of the skin's base, z points out of the skin, x along the columns and y along the rows of the nominal
camera. The camera has two frames by REP 103: ``camera`` with x along the optical axis, y to the left of its image and
z up, and ``camera_optical`` with z along the optical axis, x to the right and y down, which is `palpate.camera`'s
own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from palpate.camera import Camera
from palpate.core import FloatArray, PalpateError
from palpate.design import SurfaceMesh
from palpate.fea import Branch, ObstacleSpec, Press, WallSpec
from palpate.study.asset_shell import skin_surface
from palpate.study.asset_spec import AssetSpec
from palpate.study.mass import MassProperties, compute_mass_properties

OPTICAL_FROM_BODY = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""REP 103: x, y, z of a camera's body in its optical frame, as columns."""
_STRAIGHT_DEG = 1e-6
"""Tilt up to which a wall counts as untilted."""
_TERMS = 3
"""Terms of the polynomial of force over depth. By hand."""


@dataclass(frozen=True, eq=False)
class SensorAsset:
    """One sensor for simulators.

    Attributes
    ----------
    name
        Name of its root frame, and prefix of all other names.
    spec
        Settings.
    surface
        The skin's surface, mm, in the sensor's frame.
    body
        Mass properties of the skin.
    camera
        Camera in the sensor's frame.
    spring
        (3,) N/m, N/m², N/m³: the force of an untilted wall at depth d is ``d (s0 + s1 d + s2 d²)``.
    stiffness
        Best linear fit through first contact, N/m.
    reach
        Maximum depth of the press, m.
    spring_rms, stiffness_rms
        RMS residuals of the two fits, N.
        N root mean square by which the press differs from either.
    """

    name: str
    spec: AssetSpec
    surface: SurfaceMesh
    body: MassProperties
    camera: Camera
    spring: FloatArray
    stiffness: float
    reach: float
    spring_rms: float
    stiffness_rms: float

    @property
    def damping(self) -> float:
        """N s/m of a touch: that many times the critical one of the dome's mass on its mean stiffness."""
        return 2.0 * self.spec.damping_ratio * float(np.sqrt(self.stiffness * self.body.mass_kg))

    @property
    def camera_position(self) -> FloatArray:
        """(3,) m: the pinhole in the sensor's frame."""
        return self.camera.origin / 1e3

    @property
    def sensor_from_optical(self) -> FloatArray:
        """(3, 3) axes of ``camera_optical`` in the sensor's frame, as columns."""
        return self.camera.camera_from_dome.T


def check_force_curve_press(wall: ObstacleSpec) -> None:
    """Reject presses that give no force curve, before they are solved.

    Raises
    ------
    PalpateError
        If the obstacle is not an untilted flat wall, or has too few depth steps.
    """
    if not isinstance(wall, WallSpec) or wall.radial > _STRAIGHT_DEG or wall.curvature:
        raise PalpateError(
            f"The skin is pressed by {wall.label}.",
            "Press it by a straight flat wall: --tilt 0.",
            code="asset-wall-not-straight",
        )
    if wall.depth < _TERMS * wall.depth_step:
        raise PalpateError(
            f"A press to {wall.depth:g} mm in steps of {wall.depth_step:g} mm is too short for a force curve.",
            f"Press to {_TERMS * wall.depth_step:g} mm or deeper, or in shorter steps.",
            code="asset-press-short",
        )


def build_asset(press: Press, camera: Camera, spec: AssetSpec | None = None) -> SensorAsset:
    """Make the asset of a skin, from the press by an untilted wall, and of its camera.

    Raises
    ------
    PalpateError
        As `check_force_curve_press`, or if the press ended or jumped too early.
    """
    spec = spec or AssetSpec()
    skin = press.mesh.skin
    check_force_curve_press(press.obstacle)
    kept = (press.branch == Branch.FLAT) & ~(press.depth >= press.jump_depth)
    depth, force = press.depth[kept] / 1e3, press.force[kept, 2]
    if len(depth) <= _TERMS:
        raise PalpateError(
            f"The press has {len(depth)} images before it ends or jumps; a force curve needs {_TERMS + 1}.",
            "Press in shorter steps.",
            code="asset-few-images",
        )
    spring, spring_rms = _fit(depth, force, _TERMS)
    line, line_rms = _fit(depth, force, 1)
    return SensorAsset(
        name=spec.name or "palpate_" + "".join(letter if letter.isalnum() else "_" for letter in skin.name.lower()),
        spec=spec,
        surface=skin_surface(skin),
        body=compute_mass_properties(skin, spec.density, filled=press.mesh.filling > 0),
        camera=camera,
        spring=spring,
        stiffness=float(line[0]),
        reach=float(depth[-1]),
        spring_rms=spring_rms,
        stiffness_rms=line_rms,
    )


def _fit(depth: FloatArray, force: FloatArray, terms: int) -> tuple[FloatArray, float]:
    """Fit coefficients (terms,) of ``d (s0 + s1 d + …)`` to a force; return them and the RMS residual, N.

    If the fitted curve decreases anywhere, non-negative coefficients are fitted, as for a stable spring.
    """
    order = np.arange(1, terms + 1)
    powers = depth[:, None] ** order
    scale = powers.max(axis=0)
    found = np.linalg.lstsq(powers / scale, force, rcond=None)[0] / scale
    if (order * depth[:, None] ** (order - 1) @ found <= 0).any():
        found = nnls(powers / scale, force)[0] / scale
    return found, float(np.sqrt(np.mean((powers @ found - force) ** 2)))
