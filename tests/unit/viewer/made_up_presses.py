"""Presses in closed form on a real mesh, and a result folder that holds them: only for tests.

The displacement is a function of the undeformed point, the axis and the wall's normal alone, so it has the symmetries
of a real press; nothing is solved.
"""

import json
from pathlib import Path

import numpy as np

from palpate.design import DomeSpec, build_skin
from palpate.fea import Press, WallSpec, write_press
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin

STEP = 0.8
MESH = mesh_skin(build_skin(DomeSpec(height=20, thickness=2)), MeshSpec(cells=6))
KEYS = {tilt: f"{int(tilt):032x}" for tilt in (0.0, 3.0, 6.0)}


def moved(points, tilt_deg, depth):
    """Displacement (n, 3) mm of points (n, 3) in the tilt frame."""
    t = np.radians(tilt_deg)
    normal = np.array([0.0, -np.sin(t), np.cos(t)])
    nearness = np.exp(-(22.0 - points @ normal) / 15.0)[:, None]
    outward = points - (points @ normal)[:, None] * normal
    clamp = np.clip(points[:, 2:] / 20.0, 0, None) ** 2
    return clamp * (-depth * nearness * np.array([0, 0, 1.0]) + 0.02 * depth * outward * (1 - nearness))


def made_up_press(tilt_deg=0.0, reached=4.0, inverted_from=np.inf, mesh=MESH, move=moved, azimuth_deg=0.0):
    depth = STEP * np.arange(int(reached / STEP + 1e-9) + 1)
    if reached - depth[-1] > 1e-6:
        depth = np.append(depth, reached)
    n = len(depth)
    force = np.zeros((n, 3))
    force[:, 2] = 0.1 * depth
    return Press(
        mesh=mesh,
        material=get_material("zaid_2024_ecoflex_00_30"),
        obstacle=WallSpec(tilt_deg=tilt_deg, azimuth_deg=azimuth_deg, depth=4.0),
        solver=SolverSpec(),
        depth=depth,
        displacement=np.stack([move(mesh.nodes, tilt_deg, d) for d in depth]),
        force=force,
        **{name: np.zeros(n) for name in ("energy", "contact_energy", "dissipation", "work", "peak_stress")},
        **{name: np.zeros(n) for name in ("contact_area", "apex_gap", "stabilisation_tension")},
        branch=np.where(depth >= inverted_from, "inverted", "flat"),
        negative_pivots=np.zeros(n, int),
        ended="depth reached" if reached == 4.0 else "the branch ended",
        ended_depth=reached,
        jump_depth=float("nan"),
        cpu_s=0.1,
        unknowns=1,
        newton_iterations=1,
    )


def rows():
    """Rows of a grid of one dome: two with presses, one whose chain broke."""
    made = []
    for number, markers in enumerate((7, 19, 37)):
        broken = number == 2
        made.append(
            {
                "height_mm": 20.0,
                "base_radius_mm": 20.0,
                "thickness_mm": 2.0,
                "shape": "hemisphere",
                "markers": markers,
                "rmse_deg": None if broken else 0.5 / (number + 1),
                "rmse_jitter_deg": None if broken else 1.5 / (number + 1),
                "travel_mm": None if broken else 1.0,
                "force_n": None if broken else 0.4,
                "bistable_from_mm": 3.2,
                "spec": json.dumps({"camera": {}, "obstacle": {"contact": "no-slip"}}),
                "press_key": "" if broken else " ".join(KEYS.values()),
                "dataset_key": "",
                "estimator_key": "",
                "failure": "The press did not converge." if broken else "",
            }
        )
    return tuple(made)


def depths():
    """Errors and limits by depth of the two designs that have them."""
    figures = ((0.8, 1.2, 1.0), (1.6, 0.7, 0.5))
    return tuple(
        {"design": design, "depth_mm": depth, "rmse_jitter_deg": rmse, "bound_deg": limit}
        for design in (0, 1)
        for depth, rmse, limit in figures
    )


def write_results(folder: Path) -> Path:
    """A result folder with the presses of one dome."""
    tables = {"designs": rows(), "by_depth": depths(), "by_tilt": (), "presses": ()}
    content = {"format": "palpate specification grid", "version": 2, **tables}
    (folder / "grid.json").write_text(json.dumps(content))
    for tilt, key in KEYS.items():
        path = folder / "store" / "press" / key[:2] / f"{key}.h5"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_press(path, made_up_press(tilt))
    return folder
