"""Design: skins, marker layouts, poses and the geometry of solids."""

from palpate.design.build_skin import SKINS, build_skin, read_skin, skin_from_data
from palpate.design.check_design import check_design, raise_on_errors
from palpate.design.cone import ConeSpec
from palpate.design.contact_module import ContactModule, build_contact_module
from palpate.design.design import Design
from palpate.design.dome import Dome, DomeSpec
from palpate.design.ellipsoid import EllipsoidSpec
from palpate.design.finding import Finding, Severity
from palpate.design.markers import PRINT_TOLERANCE, MarkerLayout
from palpate.design.orientation_mark import place_orientation_mark
from palpate.design.outline import Arc, Outline, Point, SmoothCurve
from palpate.design.place_markers import place_markers
from palpate.design.points_file import read_points
from palpate.design.pose import PoseDensity, rotation_vector, turn_about_axis, wall_normal
from palpate.design.pose_estimate import PoseEstimate
from palpate.design.pose_space import OFFSET_SPACE, TILT_SPACE, PoseSpace
from palpate.design.profile import Profile, read_profile
from palpate.design.revolved import RevolvedSkin
from palpate.design.rings import markers_in_rings, ring_diameters
from palpate.design.skin import Rim, Skin, Symmetry
from palpate.design.solid import (
    CadSolid,
    SurfaceMesh,
    box,
    cylinder,
    extrude,
    gather,
    revolve,
    write_step,
)
from palpate.design.spec import MarkerSpec, MountSpec, SkinSpec
from palpate.design.spline import SplineSpec

__all__ = [
    "OFFSET_SPACE",
    "PRINT_TOLERANCE",
    "SKINS",
    "TILT_SPACE",
    "Arc",
    "CadSolid",
    "ConeSpec",
    "ContactModule",
    "Design",
    "Dome",
    "DomeSpec",
    "EllipsoidSpec",
    "Finding",
    "MarkerLayout",
    "MarkerSpec",
    "MountSpec",
    "Outline",
    "Point",
    "PoseDensity",
    "PoseEstimate",
    "PoseSpace",
    "Profile",
    "RevolvedSkin",
    "Rim",
    "Severity",
    "Skin",
    "SkinSpec",
    "SmoothCurve",
    "SplineSpec",
    "SurfaceMesh",
    "Symmetry",
    "box",
    "build_contact_module",
    "build_skin",
    "check_design",
    "cylinder",
    "extrude",
    "gather",
    "markers_in_rings",
    "place_markers",
    "place_orientation_mark",
    "raise_on_errors",
    "read_points",
    "read_profile",
    "read_skin",
    "revolve",
    "ring_diameters",
    "rotation_vector",
    "skin_from_data",
    "turn_about_axis",
    "wall_normal",
    "write_step",
]
