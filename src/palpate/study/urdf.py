"""Asset as URDF: one link for the skin, two for the camera by REP 103; contacts in Gazebo's terms."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray
from palpate.study.asset import SensorAsset

_OPTICAL_FROM_BODY_RPY = np.array([0.5, -0.5, 0.0]) * np.pi
"""`palpate.study.OPTICAL_FROM_BODY` as roll, pitch and yaw: at this pitch no formula applies."""


def urdf_text(asset: SensorAsset, mesh: str) -> str:
    """Return the robot as XML; `mesh` is the name of the skin's file in the same folder."""
    name, root = asset.name, Element("robot", name=asset.name)
    link = SubElement(root, "link", name=name)
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=_text(asset.body.centre_mm / 1e3), rpy="0 0 0")
    SubElement(inertial, "mass", value=_text(asset.body.mass_kg))
    pairs = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    products = {f"i{'xyz'[i]}{'xyz'[j]}": _text(asset.body.inertia[i, j]) for i, j in pairs}
    SubElement(inertial, "inertia", products)
    for part in ("visual", "collision"):
        geometry = SubElement(SubElement(link, part), "geometry")
        SubElement(geometry, "mesh", filename=mesh, scale="0.001 0.001 0.001")
    optical = f"{name}_camera_optical"
    turned = Rotation.from_matrix(asset.sensor_from_optical).as_euler("xyz")
    _add_frame(root, (name, optical), asset.camera_position, turned)
    _add_frame(root, (optical, f"{name}_camera"), np.zeros(3), _OPTICAL_FROM_BODY_RPY)
    contact = SubElement(root, "gazebo", reference=name)
    values = {"mu1": asset.spec.friction, "mu2": asset.spec.friction, "kp": asset.stiffness, "kd": asset.damping}
    for key, value in values.items():
        SubElement(contact, key).text = _text(value)
    indent(root)
    return '<?xml version="1.0"?>\n' + tostring(root, encoding="unicode") + "\n"


def _add_frame(root: Element, names: tuple[str, str], position: FloatArray, rpy: FloatArray) -> None:
    """Add a link without a body, fixed in its parent; `names` are the parent's and its own."""
    parent, child = names
    SubElement(root, "link", name=child)
    joint = SubElement(root, "joint", name=f"{child}_joint", type="fixed")
    SubElement(joint, "origin", xyz=_text(position), rpy=_text(rpy))
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)


def _text(values: FloatArray | float) -> str:
    return " ".join(f"{value:.12g}" for value in np.atleast_1d(values))
