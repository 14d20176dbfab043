"""A small chain for tests: coarse presses of a dome, and a model fitted to them in closed form."""

import numpy as np

from palpate.camera import build_camera
from palpate.core import ArtefactStore
from palpate.datasets import DatasetSpec, generate_dataset
from palpate.design import Design, DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec
from palpate.learn import fit_ridge, write_estimator
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.simulation import VirtualBench, VirtualBenchSpec
from palpate.surrogate import twin_derivatives, write_twin
from presses import build_twin, solve_press

DOME = DomeSpec()
MARKERS = MarkerSpec(count=37)
MATERIAL = get_material("zaid_2024_ecoflex_00_30")
CELLS = 6
TILTS = (0.0, 4.0, 8.0)
TWIN_CELLS = 9
TWIN_TILTS, TWIN_CONTACTS, TWIN_DEPTH = (0.0, 4.0, 8.0, 12.0), ("no-slip", 1.4, 0.8, 0.4), 4.0
EDGE_SHARE = 1.0
"""Increments of twice the usual length, in the presses of a twin and in those it is compared with."""


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


def twin_presses():
    """Presses of the small dome for tilts up to 12° and every friction: those of the one twin of most tests."""
    walls = [
        WallSpec(tilt_deg=tilt, contact=contact, depth=TWIN_DEPTH, depth_step=0.5)
        for contact in TWIN_CONTACTS
        for tilt in TWIN_TILTS
    ]
    mesh = mesh_skin(build_skin(DOME), MeshSpec(cells=TWIN_CELLS))
    found = []
    for wall in walls:
        solver = SolverSpec(derivatives=twin_derivatives(filled=False, friction=wall.friction), edge_share=EDGE_SHARE)
        found.append(solve_press(mesh, MATERIAL, wall, solver))
    return found


def small_twin():
    """Twin of the small dome for tilts up to 12° and every friction; the one twin of tests that need no other."""
    return build_twin(twin_presses())


def write_small_twin(path):
    write_twin(path, small_twin())
    return path


def small_bench(folder, model, **spec):
    chosen = {"units": 1, "tilts": 2, "azimuths": 2, "max_tilt_deg": 8.0, "depth": 5.0, "depth_step": 0.9}
    chosen |= {"cells": CELLS, "min_depth": 2.0} | spec
    return VirtualBench(
        VirtualBenchSpec(**chosen), Design(DOME, MARKERS, material=MATERIAL), model, ArtefactStore(folder / "store")
    )


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
