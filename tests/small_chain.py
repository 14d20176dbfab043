"""A small chain for tests: coarse presses of a dome, and a model fitted to them in closed form."""

import numpy as np

from palpate.bench import VirtualBench, VirtualBenchSpec
from palpate.camera import CameraSpec, build_camera
from palpate.core import ArtefactStore
from palpate.dataset import DatasetSpec, generate_dataset
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec
from palpate.learn import fit_ridge, write_estimator
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.twin import TWIN_DERIVATIVES, write_twin
from presses import build_twin, solve_press

DOME = DomeSpec()
MARKERS = MarkerSpec(count=37)
MATERIAL = get_material("zaid_2024_ecoflex_00_30")
CELLS = 6
TILTS = (0.0, 4.0, 8.0)


def solve(tilt_deg, **wall):
    mesh = mesh_skin(build_skin(DOME), MeshSpec(cells=CELLS))
    return solve_press(mesh, MATERIAL, WallSpec(tilt_deg=tilt_deg, depth=5.0, depth_step=1.0, **wall))


def small_dataset(**spec):
    presses = [solve(tilt) for tilt in TILTS]
    chosen = DatasetSpec(n_presses=300, max_tilt_deg=8.0, **{"jitter_px": 0.2} | spec)
    return generate_dataset(presses, place_markers(build_skin(DOME), MARKERS), build_camera(), chosen)


def write_small_model(path):
    write_estimator(path, fit_ridge(small_dataset()))
    return path


def write_small_twin(path):
    contacts, solver = ("no-slip", 1.4, 0.8, 0.4), SolverSpec(derivatives=TWIN_DERIVATIVES)
    walls = [
        WallSpec(tilt_deg=tilt, depth=5.0, depth_step=0.5, contact=contact)
        for contact in contacts
        for tilt in (0.0, 3.0, 6.0, 9.0)
    ]
    mesh = mesh_skin(build_skin(DOME), MeshSpec(cells=CELLS))
    write_twin(path, build_twin([solve_press(mesh, MATERIAL, wall, solver) for wall in walls]))
    return path


def small_bench(folder, model, **spec):
    chosen = {"units": 1, "tilts": 2, "azimuths": 2, "max_tilt_deg": 8.0, "depth": 5.0, "depth_step": 0.9}
    chosen |= {"cells": CELLS, "min_depth": 2.0} | spec
    return VirtualBench(
        VirtualBenchSpec(**chosen), DOME, MARKERS, MATERIAL, CameraSpec(), model, ArtefactStore(folder / "store")
    )


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
