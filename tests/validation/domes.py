"""Presses of domes compared with an axisymmetric solid code and with CalculiX (inclined wall).

The wall is frictionless, the base annulus fixed, the rim cut flat. Untilted presses are compared on the flat branch,
up to the depth at which the reference's apex leaves the wall or is about to.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.design import Dome, DomeSpec, build_skin
from palpate.fea import Branch, Press, WallSpec, solve_press
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.verify.case import Row, compare
from palpate.verify.read_reference import Reference, read_reference
from validation import REFERENCE

FLAT_TO = {(20, 1): 7.2, (20, 2): 8.0, (20, 3): 8.0, (20, 4): 8.0, (10, 2): 6.4, (30, 2): 8.0}
"""Height and thickness (mm) of every dome with a reference, and its flat range of depth in mm."""
_PROBES = (25, 50, 75)
"""Percent of the inner meridian, from the apex, at which the displacement is compared. By hand."""
_FINER = {(20, 4): MeshSpec(layers=2)}
"""Thick skins have two layers of cells; all others have the default mesh."""
_CALCULIX_MESH = MeshSpec(cells=24)
_STIFF = 500.0
"""Penalty over E/T of presses on other meshes; by default, contact stores 1 % of the energy at 0.8 mm."""
_SOLID_TOLERANCE = 1e-2
"""Tolerance of force, energy and displacement on the flat branch. By hand."""
_STEP_MM, _ONSET_MM = 0.1, 0.1
"""Depth step of the reference during unloading, and tolerance of the onset of the inverted branch.
By hand."""
_NEAR_MM = 0.2
"""Distance from the onset within which the gap, a square root, is not compared. By hand."""
_RING_TOLERANCE, _RING_ENERGY = 3e-2, 5e-3
"""Tolerances of force and energy: the reference's contact ring is narrow, its force scatters by 3 %."""
_SOFT_BULK = 100.0
"""K / mu of the CalculiX reference."""


def press_dome(height: int, thickness: int, wall: WallSpec, bulk_ratio: float, mesh: MeshSpec | None) -> Press:
    """Press a dome of a height and thickness (mm); with a mesh given, the contact is stiffer as well."""
    dome = build_skin(DomeSpec(height=height, thickness=thickness))
    material = get_material("zaid_2024_ecoflex_00_30").with_bulk_ratio(bulk_ratio)
    solver = None if mesh is None else SolverSpec(penalty_ratio=_STIFF)
    return solve_press(mesh_skin(dome, mesh), material, wall, solver)


def flat_branch(height: int, thickness: int) -> list[Row]:
    """Compare force, energy and three probes of the inner surface at every increment of an untilted press."""
    data = read_reference(f"dome_H{height}_T{thickness}", REFERENCE).between("apex_gap_mm", -1.0, 0.05)
    wall = WallSpec(contact="frictionless", depth=FLAT_TO[height, thickness])
    press = press_dome(height, thickness, wall, 2000.0, _FINER.get((height, thickness)))
    depth = press.depth[1:]
    at = [f"d = {value:g} mm" for value in depth]
    flat = np.array([branch == Branch.FLAT for branch in press.branch])
    rows = [
        compare("images on the flat branch", flat.sum(), len(flat), 0.0),
        compare("force, N", press.force[1:, 2], _at(data, "force_N", depth), _SOLID_TOLERANCE, at),
        compare("energy, mJ", press.energy[1:], _at(data, "strain_energy_mJ", depth), _SOLID_TOLERANCE, at),
    ]
    moved = _probe(press)
    for k, name in enumerate(_PROBES):
        expected = np.stack([_at(data, f"inner_q{name}_{axis}", depth) for axis in ("ur", "uz")], axis=-1)
        distance = np.linalg.norm(moved[1:, k, 1:] - expected, axis=1)
        rows.append(
            compare(f"probe at {name} % over the depth, mm", distance, 0 * depth, _SOLID_TOLERANCE, at, depth)
        )
    return rows


def inverted_branch(height: int, thickness: int) -> list[Row]:
    """Compare the onset depth of the inverted state, and force, energy and apex gap beyond it."""
    data = read_reference(f"dome_inverted_branch_H{height}_T{thickness}", REFERENCE).between("apex_gap_mm", 0.05, 1e3)
    wall = WallSpec(contact="frictionless")
    dome = build_skin(DomeSpec(height=height, thickness=thickness))
    material = get_material("zaid_2024_ecoflex_00_30").with_bulk_ratio(2000.0)
    press = solve_press(mesh_skin(dome), material, wall, branch=Branch.INVERTED)
    first = data["d_mm"].min() - _STEP_MM / 2
    image = press.depth >= first + _NEAR_MM
    depth = press.depth[image]
    at = [f"d = {value:.3g} mm" for value in depth]
    inverted = np.array([branch == Branch.INVERTED for branch in press.branch])
    return [
        compare("images on the inverted branch", inverted.sum(), len(inverted), 0.0),
        compare("unstable modes", press.negative_pivots.max(), 0, 0.0, scale=1.0),
        compare("inverted from, mm", press.depth.min(), first, _ONSET_MM, scale=1.0),
        compare("force, N", press.force[image, 2], _at(data, "force_N", depth), _RING_TOLERANCE, at),
        compare("energy, mJ", press.energy[image], _at(data, "strain_energy_mJ", depth), _RING_ENERGY, at),
        compare(
            "gap of the apex over the depth, mm",
            press.apex_gap[image],
            _at(data, "apex_gap_mm", depth),
            1e-2,
            at,
            depth,
        ),
    ]


def _at(data: Reference, column: str, depth: FloatArray) -> FloatArray:
    return np.interp(depth, data["d_mm"], data[column])


def _probe(press: Press) -> FloatArray:
    """Displacement (n, 3, 3) mm of the probes in the plane x = 0 at every increment."""
    dome = press.mesh.skin
    assert isinstance(dome, Dome)
    polar = np.arccos((dome.radius - dome.height) / dome.radius) * np.array(_PROBES) / 100
    place = np.stack([0 * polar, dome.radius * np.sin(polar), dome.center_z + dome.radius * np.cos(polar)], axis=-1)
    return press.positions(place) - place


def calculix(tilt: int) -> list[Row]:
    """Compare force, energy and force direction under a wall inclined by `tilt` degrees to -x, K/mu = 100."""
    data = read_reference(f"calculix_H20_T3_tilt{tilt}", REFERENCE)
    wall = WallSpec(contact="frictionless", tilt_deg=tilt, azimuth_deg=-90.0)
    press = press_dome(20, 3, wall, _SOFT_BULK, _CALCULIX_MESH)
    depth = press.depth[1:]
    at = [f"d = {value:g} mm" for value in depth]
    force = press.force[1:]
    direction = np.full(len(depth), -np.tan(np.radians(tilt)))
    return [
        compare("axial force, N", force[:, 2], _at(data, "Fz_N", depth), 4e-2, at),
        compare("energy, mJ", press.energy[1:], _at(data, "strain_energy_mJ", depth), 2e-2, at),
        compare("Fx over Fz", force[:, 0] / force[:, 2], direction, 1e-4, at, 1.0),
    ]
