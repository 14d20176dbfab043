"""Design, simulation and calibration of vision-based tactile sensors.

The names of a first press and a first grid, loaded on first use (PEP 562); the subpackages `palpate.design` to
`palpate.viewer` have the rest.

    >>> import palpate as pp
    >>> mesh = pp.mesh_skin(pp.build_skin(pp.DomeSpec(height=20)), pp.MeshSpec(cells=4))
    >>> press = pp.solve_press(mesh, pp.get_material("zaid_2024_ecoflex_00_30"), pp.WallSpec(depth=0.4))
    >>> str(press.ended)
    'depth reached'
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from palpate.camera import CameraSpec, build_camera  # type: ignore[no-redef, unused-ignore]
    from palpate.core import __version__
    from palpate.design import Design, DomeSpec, EllipsoidSpec, MarkerSpec, build_skin, place_markers  # type: ignore[no-redef, unused-ignore]
    from palpate.fea import BallSpec, WallSpec, solve_press  # type: ignore[no-redef, unused-ignore]
    from palpate.material import get_material  # type: ignore[no-redef, unused-ignore]
    from palpate.mesh import MeshSpec, mesh_skin  # type: ignore[no-redef, unused-ignore]
    from palpate.sensor import open_sensor  # type: ignore[no-redef, unused-ignore]
    from palpate.study import evaluate_grid, read_grid, read_study, run_study  # type: ignore[no-redef, unused-ignore]

_ROOMS = {
    "core": ("__version__",),
    "camera": ("CameraSpec", "build_camera"),
    "design": ("Design", "DomeSpec", "EllipsoidSpec", "MarkerSpec", "build_skin", "place_markers"),
    "fea": ("BallSpec", "WallSpec", "solve_press"),
    "material": ("get_material",),
    "mesh": ("MeshSpec", "mesh_skin"),
    "sensor": ("open_sensor",),
    "study": ("evaluate_grid", "read_grid", "read_study", "run_study"),
}
_HOME = {name: room for room, names in _ROOMS.items() for name in names}

__all__ = [
    "BallSpec",
    "CameraSpec",
    "Design",
    "DomeSpec",
    "EllipsoidSpec",
    "MarkerSpec",
    "MeshSpec",
    "WallSpec",
    "__version__",
    "build_camera",
    "build_skin",
    "evaluate_grid",
    "get_material",
    "mesh_skin",
    "open_sensor",
    "place_markers",
    "read_grid",
    "read_study",
    "run_study",
    "solve_press",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'palpate' has no attribute '{name}'")
    found = getattr(import_module(f"palpate.{_HOME[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__} - {"Any", "TYPE_CHECKING", "import_module"})
