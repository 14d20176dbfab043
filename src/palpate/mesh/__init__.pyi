"""Mesh: from a dome to quadratic hexahedra with named sets, and from any surface point to its cell."""

from palpate.mesh.hexahedron import gauss_points, shape_hexahedron, shape_quadrilateral
from palpate.mesh.locate import SurfacePoints, locate_inner, locate_nodes
from palpate.mesh.mesh import Mesh
from palpate.mesh.mesh_skin import centre_mesh, default_core, mesh_skin, reshape_mesh
from palpate.mesh.pins import marker_displacement, marker_displacement_derivative
from palpate.mesh.quality import MeshQuality, measure_quality
from palpate.mesh.spec import MeshSpec

__all__ = [
    "Mesh",
    "MeshQuality",
    "MeshSpec",
    "SurfacePoints",
    "centre_mesh",
    "default_core",
    "gauss_points",
    "locate_inner",
    "locate_nodes",
    "marker_displacement",
    "marker_displacement_derivative",
    "measure_quality",
    "mesh_skin",
    "reshape_mesh",
    "shape_hexahedron",
    "shape_quadrilateral",
]
