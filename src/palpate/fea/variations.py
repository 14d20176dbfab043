"""Parameters by which a press may be differentiated, and the press at slightly changed values of them.

=======================  ===================================================  ======
name                     parameter                                            unit
=======================  ===================================================  ======
``depth``                depth of the obstacle                                mm
``tilt_deg``             tilt of the wall, in its tilt plane                  deg
``across_deg``           tilt across that plane                               deg
``shift``                lateral motion along the tilt, after the press       mm
``shift_across``         lateral motion across the tilt, after the press      mm
``twist_deg``            twist of the wall about its normal, after the press  deg
``lateral_rate``         lateral motion along the wall's slope per depth      mm/mm
``lateral_rate_across``  lateral motion across the slope per depth            mm/mm
``twist_rate_deg``       twist of the wall about its normal per depth         deg/mm
``curvature``            curvature of the wall, convex towards the skin       1/m
``friction``             coefficient of friction                              1
``thickness``, …         any number of the skin: ``height``, ``base_radius``  mm
``C10``, …               any constant of the material                         MPa
=======================  ===================================================  ======

`depth`, `shift`, `shift_across` and `twist_deg` change the obstacle, and points that stick to it, at the depth
reached; all others act from rest on. A change of thickness leaves the inner surface and its markers in place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design import build_skin, rotation_vector, skin_from_data, turn_about_axis, wall_normal
from palpate.fea.spec import ObstacleSpec, translate_obstacle
from palpate.fea.wall import Plane, WallSpec, drifting, slope_ways
from palpate.material import Material, material_from_data
from palpate.mechanics import ContactLoading, Obstacle, Solid, Variation
from palpate.mesh import Mesh, reshape_mesh

_POSE = ("depth", "tilt_deg", "across_deg", "shift", "shift_across", "twist_deg")
WALL_NAMES = (*_POSE, *WallSpec.LATERAL_FIELDS, "curvature", "friction")
"""Names of derivatives of a press by a flat wall, without those of its skin and its material."""
_STEP = 1e-7
"""Half the difference of a parameter, mm, degrees or 1; relative for a material constant. By hand."""
_CURVATURE_STEP = 3e-6
"""Half the difference of a curvature, 1/m: some 1e-7 mm at the edge of a patch. By hand."""


@dataclass(frozen=True)
class PathInputs:
    """Inputs of a load path: those of the press, and its `loading` and `solid`.

    `load` makes the loading of a mesh, material and wall.
    """

    mesh: Mesh
    material: Material
    obstacle: ObstacleSpec
    load: Callable[[Mesh, Material, ObstacleSpec], ContactLoading]
    loading: ContactLoading
    solid: Solid


def parameter_names(mesh: Mesh, material: Material, obstacle: ObstacleSpec) -> tuple[str, ...]:
    """Return the names by which a press may be differentiated."""
    if obstacle.sideways:
        return tuple(material.key_data()["constants"])
    contact = [name for name in WALL_NAMES if name != "friction" or 0 < obstacle.friction < np.inf]
    if not isinstance(obstacle, WallSpec):
        contact = [name for name in contact if name in ("depth", "shift", "shift_across", "friction")]
    sizes = {} if mesh.filling else mesh.skin.spec_data
    skin = [name for name, value in sizes.items() if isinstance(value, float) and name != "pin"]  # pins bear nothing
    return (*contact, *skin, *material.key_data()["constants"])


def make_variations(made: PathInputs, names: Sequence[str]) -> tuple[Variation, ...]:
    """Return the variations of these names.

    Raises
    ------
    PalpateError
        If the press cannot be differentiated by a name.
    """
    known = parameter_names(made.mesh, made.material, made.obstacle)
    unknown = [name for name in names if name not in known]
    if unknown:
        raise PalpateError(
            f"A press has no derivative by '{unknown[0]}'.",
            f"Choose from {', '.join(known)}.",
            code="derivative-unknown",
        )
    return tuple(_vary(made, name) for name in names)


def _vary(made: PathInputs, name: str) -> Variation:
    if name in made.material.key_data()["constants"]:
        return _vary_material(made, name)
    if name in made.mesh.skin.spec_data:
        return _vary_skin(made, name)
    if name == "friction":
        high, low = (_with_friction(made.loading, made.loading.law.friction + by) for by in (_STEP, -_STEP))
        return Variation(name, _STEP, high, low)
    if name in ("tilt_deg", "across_deg"):
        return _vary_wall(made, name)
    if name in WallSpec.LATERAL_FIELDS:
        return _vary_drift(made, name)
    if name == "curvature":
        return _vary_curvature(made)
    half = not made.mesh.spec.whole
    if name == "twist_deg":
        high, low = (
            replace(made.loading, obstacle=partial(_twisted, made.loading.obstacle, np.radians(by)))
            for by in (_STEP, -_STEP)
        )
        return Variation(name, _STEP, high, low, lasting=False, antisymmetric=half)
    turn = np.eye(3) if half else turn_about_axis(np.radians(made.obstacle.turn_deg))
    way = turn @ {"depth": [0.0, 0.0, -1.0], "shift": [0.0, 1.0, 0.0], "shift_across": [1.0, 0.0, 0.0]}[name]
    high, low = (
        replace(made.loading, obstacle=partial(_travelled, made.loading.obstacle, by * way)) for by in (_STEP, -_STEP)
    )
    return Variation(name, _STEP, high, low, lasting=False, antisymmetric=half and name == "shift_across")


def _travelled(obstacle: Callable[[float], Obstacle], by: FloatArray, depth: float) -> Obstacle:
    return obstacle(depth).moved(by)


def _twisted(obstacle: Callable[[float], Obstacle], by: float, depth: float) -> Obstacle:
    plane = obstacle(depth)
    assert isinstance(plane, Plane)
    return plane.twisted(by)


def _vary_drift(made: PathInputs, name: str) -> Variation:
    """Vary the lateral motion or twist of the wall per depth."""
    assert isinstance(made.obstacle, WallSpec)
    touched = made.loading.obstacle(0.0)
    assert isinstance(touched, Plane)
    half = not made.mesh.spec.whole
    ways = slope_ways(touched.normal, 0.0 if half else np.radians(made.obstacle.azimuth_deg))
    way = {"lateral_rate": ways[0], "lateral_rate_across": ways[1]}.get(name, np.zeros(3))
    twist = np.radians(1.0) if name == "twist_rate_deg" else 0.0
    high, low = (
        replace(made.loading, obstacle=partial(drifting, made.loading.obstacle, by * way, by * twist))
        for by in (_STEP, -_STEP)
    )
    return Variation(name, _STEP, high, low, antisymmetric=half and name != "lateral_rate", sideways=True)


def _vary_curvature(made: PathInputs) -> Variation:
    """Vary the curvature of the wall."""
    touched = made.loading.obstacle(0.0)
    assert isinstance(touched, Plane)
    high, low = (
        replace(made.loading, obstacle=partial(_bent, made.loading.obstacle, 1e-3 * by))
        for by in (_CURVATURE_STEP, -_CURVATURE_STEP)
    )
    return Variation("curvature", _CURVATURE_STEP, high, low)


def _bent(obstacle: Callable[[float], Obstacle], by: float, depth: float) -> Obstacle:
    plane = obstacle(depth)
    assert isinstance(plane, Plane)
    return replace(plane, curvature=plane.curvature + by)


def _vary_wall(made: PathInputs, name: str) -> Variation:
    """Vary the tilt of the wall, from first contact on."""
    assert isinstance(made.obstacle, WallSpec)
    across = name == "across_deg"
    azimuth = np.radians(made.obstacle.azimuth_deg) if made.mesh.spec.whole else 0.0
    along = rotation_vector(np.radians(made.obstacle.tilt_deg), azimuth)
    unit = rotation_vector(1.0, azimuth + (np.pi / 2 if across else 0.0))
    sides = []
    for by in (_STEP, -_STEP):
        normal = wall_normal(*(along + np.radians(by) * unit))
        touched = Plane(normal, made.mesh.skin.support_point(normal), curvature=1e-3 * made.obstacle.curvature)
        sides.append(
            replace(
                made.loading, obstacle=partial(translate_obstacle, touched, made.obstacle.approach_axis(made.mesh))
            )
        )
    return Variation(name, _STEP, sides[0], sides[1], antisymmetric=across and not made.mesh.spec.whole)


def _vary_skin(made: PathInputs, name: str) -> Variation:
    """Vary the shape of the skin, with the same mesh topology and a new first contact."""
    sides = []
    for by in (_STEP, -_STEP):
        data = made.mesh.skin.spec_data
        sides.append(reshape_mesh(made.mesh, build_skin(skin_from_data(data | {name: data[name] + by}))))
    high, low = (made.load(mesh, made.material, made.obstacle) for mesh in sides)
    solids = (made.solid.remade(sides[0].nodes, made.material), made.solid.remade(sides[1].nodes, made.material))
    return Variation(name, _STEP, high, low, solids)


def _vary_material(made: PathInputs, name: str) -> Variation:
    """Vary a constant of the material; the contact penalty scales with its stiffness."""
    data = made.material.key_data()
    step = _STEP * abs(float(data["constants"][name]))
    sides = []
    for by in (step, -step):
        constants = data["constants"] | {name: data["constants"][name] + by}
        sides.append(material_from_data({"name": made.material.name, **data, "constants": constants}))
    high, low = (made.load(made.mesh, material, made.obstacle) for material in sides)
    solids = (made.solid.remade(made.mesh.nodes, sides[0]), made.solid.remade(made.mesh.nodes, sides[1]))
    return Variation(name, step, high, low, solids)


def _with_friction(loading: ContactLoading, friction: float) -> ContactLoading:
    return replace(loading, law=loading.law._replace(friction=friction))
