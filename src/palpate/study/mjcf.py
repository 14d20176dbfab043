"""Asset for MuJoCo.

MuJoCo scales the compliance of a contact with the masses of the bodies, so that one parameter does not give one
force. Therefore the contact is stiff, and the skin is on a joint ``NAME_depth`` whose spring has the press's force
curve. Its position is the depth of a wall, m. Half of the mass moves with the joint; its weight is compensated and
added to the fixed half, so that the spring does not sag and the total weight is right.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from palpate.core import FloatArray
from palpate.study.asset import SensorAsset

_OPENGL_FROM_OPTICAL = np.diag([1.0, -1.0, -1.0])
_STIFF = {"priority": "1", "solref": "0.004 1", "solimp": "0.99 0.999 0.0001"}
"""Contact with a few hundredths of the spring's compliance, for any body, at steps up to 2 ms."""


def mjcf_text(asset: SensorAsset, mesh: str) -> str:
    """Return the model as XML; `mesh` is the name of the skin's file in the same folder."""
    name, root = asset.name, Element("mujoco", model=asset.name)
    SubElement(root, "compiler", angle="radian", autolimits="true")
    SubElement(SubElement(root, "asset"), "mesh", name=f"{name}_skin", file=mesh, scale="0.001 0.001 0.001")
    sensor = SubElement(SubElement(root, "worldbody"), "body", name=name, gravcomp="-1")
    _add_half(sensor, asset)
    _add_camera(sensor, asset)
    skin = SubElement(sensor, "body", name=f"{name}_skin", gravcomp="1")
    _add_half(skin, asset)
    spring = {"stiffness": _text(asset.spring), "damping": _text(asset.damping), "range": _text([0.0, asset.reach])}
    SubElement(skin, "joint", spring, name=f"{name}_depth", type="slide", axis="0 0 -1")
    touch = {"mass": "0", "friction": _text(asset.spec.friction), **_STIFF}
    SubElement(skin, "geom", touch, name=f"{name}_skin", type="mesh", mesh=f"{name}_skin")
    SubElement(SubElement(root, "sensor"), "jointpos", name=f"{name}_depth", joint=f"{name}_depth")
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def _add_half(body: Element, asset: SensorAsset) -> None:
    """Add half of mass and inertia."""
    half = asset.body.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]] / 2
    values = {"pos": _text(asset.body.centre_mm / 1e3), "mass": _text(asset.body.mass_kg / 2)}
    SubElement(body, "inertial", values, fullinertia=_text(half))


def _add_camera(sensor: Element, asset: SensorAsset) -> None:
    """Add a camera with the same pinhole and image centre; MuJoCo has no lens distortion."""
    spec, axes = asset.camera.spec, asset.sensor_from_optical @ _OPENGL_FROM_OPTICAL
    SubElement(
        sensor,
        "camera",
        name=f"{asset.name}_camera",
        pos=_text(asset.camera_position),
        xyaxes=_text(np.concatenate([axes[:, 0], axes[:, 1]])),
        resolution=f"{spec.width_px} {spec.height_px}",
        focalpixel=_text([spec.fx_px, spec.fy_px]),
        principalpixel=_text([(spec.width_px - 1) / 2 - spec.cx_px, (spec.height_px - 1) / 2 - spec.cy_px]),
        sensorsize=_text([1e-3, 1e-3 * spec.height_px / spec.width_px]),
    )


def _text(values: FloatArray | list[float] | float) -> str:
    return " ".join(f"{value:.9g}" for value in np.atleast_1d(values))
