"""Asset as USD: one text file, with the bodies of UsdPhysics and the compliant contact of PhysX."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray
from palpate.study.asset import SensorAsset

_OPENGL_FROM_OPTICAL = np.diag([1.0, -1.0, -1.0])
_APERTURE = 20.0
"""Aperture of the camera, tenths of a scene unit: only its ratio to the focal length matters."""

_STAGE = """#usda 1.0
(
    defaultPrim = "{name}"
    metersPerUnit = 1
    kilogramsPerUnit = 1
    upAxis = "Z"
)

def Xform "{name}" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
)
{{
    float physics:mass = {mass}
    point3f physics:centerOfMass = {centre}
    float3 physics:diagonalInertia = {moments}
    quatf physics:principalAxes = {axes}

    def Mesh "skin" (
        prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"]
    )
    {{
        uniform token physics:approximation = "convexHull"
        uniform token subdivisionScheme = "none"
        rel material:binding:physics = </{name}/silicone>
        float3[] extent = [{extent}]
        int[] faceVertexCounts = [{counts}]
        int[] faceVertexIndices = [{corners}]
        point3f[] points = [{points}]
    }}

    def Material "silicone" (
        prepend apiSchemas = ["PhysicsMaterialAPI", "PhysxMaterialAPI"]
    )
    {{
        float physics:density = {density}
        float physics:dynamicFriction = {friction}
        float physics:staticFriction = {friction}
        float physxMaterial:compliantContactStiffness = {stiffness}
        float physxMaterial:compliantContactDamping = {damping}
    }}

    def Camera "camera"
    {{
        float focalLength = {focal}
        float horizontalAperture = {width}
        float verticalAperture = {height}
        float horizontalApertureOffset = {right}
        float verticalApertureOffset = {up}
        float2 clippingRange = (0.001, 1)
        matrix4d xformOp:transform = {pose}
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }}
}}
"""


def usd_text(asset: SensorAsset, mesh: str) -> str:
    """Return the stage as text; it contains its mesh, in m, and needs no file `mesh`."""
    points, body = asset.surface.points / 1e3, asset.body
    moments, axes = np.linalg.eigh(body.inertia)
    axes = axes * np.sign(np.linalg.det(axes))
    turned = Rotation.from_matrix(axes).as_quat(scalar_first=True)
    return _STAGE.format(
        name=asset.name,
        mass=_text(body.mass_kg),
        centre=_tuple(body.centre_mm / 1e3),
        moments=_tuple(moments),
        axes=_tuple(turned),
        extent=", ".join(map(_tuple, (points.min(axis=0), points.max(axis=0)))),
        counts=", ".join(["3"] * len(asset.surface.triangles)),
        corners=", ".join(map(str, asset.surface.triangles.ravel())),
        points=", ".join(map(_tuple, points)),
        density=_text(asset.spec.density),
        friction=_text(asset.spec.friction),
        stiffness=_text(asset.stiffness),
        damping=_text(asset.damping),
        **_camera(asset),
    )


def _camera(asset: SensorAsset) -> dict[str, str]:
    """Aperture offset and pose of the camera; the rows of a matrix are its axes."""
    spec = asset.camera.spec
    focal = _APERTURE * spec.fx_px / spec.width_px
    pixel = _APERTURE / spec.width_px, focal / spec.fy_px
    pose = np.eye(4)
    pose[:3, :3] = (asset.sensor_from_optical @ _OPENGL_FROM_OPTICAL).T
    pose[3, :3] = asset.camera_position
    return {
        "focal": _text(focal),
        "width": _text(_APERTURE),
        "height": _text(pixel[1] * spec.height_px),
        "right": _text(pixel[0] * ((spec.width_px - 1) / 2 - spec.cx_px)),
        "up": _text(pixel[1] * (spec.cy_px - (spec.height_px - 1) / 2)),
        "pose": f"( {', '.join(map(_tuple, pose))} )",
    }


def _text(value: float) -> str:
    return f"{value:.9g}"


def _tuple(values: FloatArray | Iterable[float]) -> str:
    return f"({', '.join(_text(value) for value in values)})"
