"""Compare derivatives of a press with differences of whole presses: 8 names, 6 cases, 3 contact laws.

    python benchmarks/press_derivatives.py RESULTS.csv      solve what RESULTS.csv lacks, then print the table
    python benchmarks/press_derivatives.py RESULTS.csv -t   print the table only

Where contact remembers, points join the patch one by one, and a difference of two presses has noise of its own. So
every derivative is held against the slope through presses at six places of the parameter, beside the scatter of that
slope. `shift` goes on from the press itself: its wall travels sideways and back.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from palpate.design import DomeSpec, build_skin, skin_from_data
from palpate.fea import Press, WallSpec, solve_press
from palpate.fea.solve_press import start_press
from palpate.material import Material, get_material, material_from_data
from palpate.mechanics import Obstacle, SolverSpec
from palpate.mesh import Mesh, centre_mesh, mesh_skin, reshape_mesh

MATERIAL = get_material("zaid_2024_ecoflex_00_30")
CASES = [(20, 2, 5), (20, 4, 10), (30, 2, 5), (30, 4, 12), (20, 3, 2), (10, 3, 5)]
"""Height mm, thickness mm, tilt deg."""
LAWS = ("frictionless", "no-slip", 0.5)
DEPTH, IMAGE = 4.0, 2.0
STEPS = {
    "depth": 0.02,
    "tilt_deg": 0.1,
    "thickness": 0.01,
    "height": 0.05,
    "base_radius": 0.05,
    "C10": 1e-4,
    "C20": 2e-6,
}
"""Distance of the six places from each other; a fifth of it without friction."""
PLACES = np.array([-2.5, -1.5, -0.5, 0.5, 1.5, 2.5])
COLUMNS = ["height_mm", "thickness_mm", "tilt_deg", "contact", "name", "depth_mm", "field_percent", "scatter_percent"]


def main() -> None:
    path = Path(sys.argv[1])
    rows = list(csv.DictReader(path.open(newline=""))) if path.is_file() else []
    done = {(float(row["height_mm"]), float(row["thickness_mm"]), row["contact"], row["name"]) for row in rows}
    for law in LAWS if "-t" not in sys.argv[2:] else ():
        names = (*STEPS, "friction" if isinstance(law, float) else "shift")
        for case in CASES:
            missing = [name for name in names if (float(case[0]), float(case[1]), str(law), name) not in done]
            if missing:
                rows += compare(case, law, missing)
                write(path, rows)
    print_table(rows)


def compare(case: tuple[float, float, float], law: str | float, names: list[str]) -> list[dict[str, str]]:
    """Rows of a case: error of the derivative of the field, and the scatter of the slope, in percent of its norm."""
    height, thickness, tilt = case
    wall = WallSpec(tilt_deg=tilt, contact=law, depth=DEPTH, depth_step=IMAGE)
    mesh = mesh_skin(build_skin(DomeSpec(height=height, thickness=thickness)))
    mesh = centre_mesh(mesh, wall.at_first_contact(mesh)[1])
    largest = 0.4 if law == "frictionless" else 0.2
    solver = SolverSpec(first_step=largest, largest_step=largest, tolerance=1e-8)
    press = solve_press(mesh, MATERIAL, wall, solver.model_copy(update={"derivatives": tuple(names)}))
    rows = []
    for name in names:
        found = press.derivative(name).displacement
        slopes, scatters = shifted(mesh, wall, solver) if name == "shift" else slope(mesh, wall, solver, name)
        for k in [-1] if name in ("shift", "depth") else range(1, len(slopes)):
            scale = np.linalg.norm(slopes[k])
            if name in ("C10", "C20"):  # silicone of other stiffness takes the same shape: over the field itself
                scale = np.linalg.norm(press.displacement[k]) / MATERIAL.key_data()["constants"][name]
            rows.append(
                dict(
                    zip(
                        COLUMNS,
                        (
                            *(f"{value:g}" for value in case),
                            str(law),
                            name,
                            f"{press.depth[k]:.2f}",
                            f"{100 * np.linalg.norm(found[k] - slopes[k]) / scale:.3f}",
                            f"{100 * scatters[k] / scale:.3f}",
                        ),
                        strict=True,
                    )
                )
            )
        print(case, law, name, [row["field_percent"] for row in rows if row["name"] == name], flush=True)
    return rows


def slope(mesh: Mesh, wall: WallSpec, solver: SolverSpec, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Slope (n, n_nodes, 3) of the field through six presses, and the standard error (n,) of its norm."""
    step = STEPS.get(name, 0.01) * (1.0 if wall.friction else 0.2)
    fields = np.array([beside(mesh, wall, solver, name, float(by)).displacement for by in PLACES * step])
    design = np.stack([np.ones(6), PLACES * step, (PLACES * step) ** 2, (PLACES * step) ** 3], axis=-1)
    flat = fields.reshape(6, -1)
    inverse = np.linalg.inv(design.T @ design)
    coefficients = inverse @ design.T @ flat
    left = (flat - design @ coefficients).reshape(fields.shape)
    variance = (left**2).sum(axis=(0, 2, 3)) / (6 - 4)
    return coefficients[1].reshape(fields.shape[1:]), np.sqrt(variance * inverse[1, 1])


def beside(mesh: Mesh, wall: WallSpec, solver: SolverSpec, name: str, by: float) -> Press:
    """A whole press with a parameter that differs."""
    material: Material = MATERIAL
    if name in ("tilt_deg", "depth"):
        changed = {name: getattr(wall, name) + by} | ({"depth_step": wall.depth + by} if name == "depth" else {})
        wall = wall.model_copy(update=changed)
    elif name == "friction":
        wall = wall.model_copy(update={"contact": wall.friction + by})
    elif name in ("C10", "C20"):
        data = material.key_data()
        constants = data["constants"] | {name: data["constants"][name] + by}
        material = material_from_data({"name": "other", **data, "constants": constants})
    else:
        data = mesh.skin.spec_data
        mesh = reshape_mesh(mesh, build_skin(skin_from_data(data | {name: data[name] + by})))
    return solve_press(mesh, material, wall, solver)


def shifted(mesh: Mesh, wall: WallSpec, solver: SolverSpec) -> tuple[np.ndarray, np.ndarray]:
    """The same of a wall that goes on sideways, along the tilt, from the depth of the press."""
    path = start_press(mesh, MATERIAL, wall, solver)
    assert path.advance(wall.depth)
    last, descent, along = path.last, path.loading.obstacle, np.array([0.0, 1.0, 0.0])
    places, fields = 0.002 * np.array([-2.0, -1.0, 1.0, 2.0]), []
    for place in places:
        aside = partial(displaced, descent, place * along)
        terms = replace(path.loading, obstacle=aside).terms(last.depth, last.history)
        found = path.problem.solve(last.state, terms, 40)
        assert found.converged
        fields.append(found.state.u)
    flat = np.array(fields).reshape(4, -1)
    design = np.stack([np.ones(4), places, places**2], axis=-1)
    coefficients = np.linalg.lstsq(design, flat, rcond=None)[0]
    left = flat - design @ coefficients
    error = np.sqrt((left**2).sum() * np.linalg.inv(design.T @ design)[1, 1])
    return coefficients[1].reshape(1, *fields[0].shape), np.array([error])


def displaced(descent: Callable[[float], Obstacle], by: np.ndarray, at: float) -> Obstacle:
    return descent(at).moved(by)


def write(path: Path, rows: list[dict[str, str]]) -> None:
    part = path.with_suffix(".part")
    with part.open("w", newline="") as file:
        out = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        out.writeheader()
        out.writerows(rows)
    part.replace(path)


def print_table(rows: list[dict[str, str]]) -> None:
    """Greatest error over the cases, beside the scatter of the slopes it is held against."""
    for law in LAWS:
        for name in dict.fromkeys(row["name"] for row in rows if row["contact"] == str(law)):
            mine = [row for row in rows if row["contact"] == str(law) and row["name"] == name]
            error, scatter = (np.array([float(row[key]) for row in mine]) for key in COLUMNS[-2:])
            print(
                f"{law!s:>12} {name:>12}: field {np.median(error):6.2f} % median, {error.max():6.2f} at most; "
                f"standard error of the slope of presses {np.median(scatter):6.2f}, {scatter.max():6.2f}"
            )


if __name__ == "__main__":
    main()
