"""Presses, twins and a tiny study for tests, each computed once per state of the source.

Results lie outside the repository, in the folder `PALPATE_TEST_STORE` or the user's cache. Their key contains the
inputs, the syntax of the source (without docstrings and comments), and the versions of numpy, scipy, numba and the
linear solver. Workers and later runs share them; a changed source computes them again.
"""

import fcntl
import hashlib
import inspect
import json
import os
import pickle
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from palpate import fea
from palpate import surrogate as twins
from palpate.design import DomeSpec, build_skin
from palpate.fea import Branch, ObstacleSpec, Press, WallSpec
from palpate.material import Material, get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import Mesh, MeshSpec, mesh_skin
from palpate.surrogate import Twin
from source_stamp import SOURCE, source_stamp

OLD_S = 14 * 86400.0
"""Age after which results of another state of the source are removed."""

TINY_STUDY = """
name: tiny
seed: 3
designs:
  heights: [20 mm]
  thicknesses: [2 mm]
  markers: [7, 19]
mesh: {cells: 8}
tilts_deg: [0, 3, 6]
obstacle: {depth: 4 mm}
dataset: {n_presses: 60, max_tilt_deg: 6}
learning: {preset: quick}
built: null
"""
"""A study of minutes cut down to seconds: coarse mesh, three tilts, shallow presses, tiny training."""


def solve_press(
    mesh: Mesh,
    material: Material,
    obstacle: ObstacleSpec | None = None,
    solver: SolverSpec | None = None,
    branch: Branch = Branch.FLAT,
) -> Press:
    """Press of a skin as `palpate.fea.solve_press` returns it, from the store if it was solved before."""
    obstacle, solver = obstacle or WallSpec(), solver or SolverSpec()
    inputs = (*_mesh_parts(mesh), _data(material.key_data()), *_spec_parts(obstacle), *_spec_parts(solver), branch)

    def solve() -> Press:
        _compile_kernels()
        return fea.solve_press(mesh, material, obstacle, solver, branch)

    return stored("press", inputs, solve)


def build_twin(presses: Iterable[Press], inverted: Iterable[Press] = ()) -> Twin:
    """Twin of presses, as `palpate.surrogate.build_twin` returns it, from the store if it was built before."""
    flat, mirrored = list(presses), list(inverted)
    inputs = [hashlib.sha256(pickle.dumps(one)).hexdigest() for one in (flat, mirrored)]
    return stored("twin", inputs, lambda: twins.build_twin(flat, mirrored))


def run_tiny_study(folder: Path) -> Path:
    """Copy the results of `TINY_STUDY` to a folder; return the folder."""
    shutil.copytree(study_results(TINY_STUDY), folder, dirs_exist_ok=True)
    return folder


def study_results(text: str) -> Path:
    """Return the results of a study, run once by the command line with two workers; only to be read."""

    def run(made: Path) -> None:
        study = made / "study.yaml"
        study.write_text(text)
        words = [sys.executable, "-m", "palpate", "run", str(study), "--out", str(made / "results"), "--workers", "2"]
        done = subprocess.run(words, cwd=SOURCE.parent, capture_output=True, text=True, timeout=1800)
        assert done.returncode == 0, done.stderr

    return stored_folder("study", [text], run) / "results"


def copy_learnt_sensor(folder: Path) -> Path:
    """Copy a folder of `palpate recording train`, with the recording below it, to a new folder; return it."""
    import drawn_tactip  # here: it draws by a library that not every environment has

    def learn(made: Path) -> None:
        motions, sensor = drawn_tactip.draw_motions(64, 1, shear=2.0), drawn_tactip.DrawnSensor(rings=4)
        drawn_tactip.draw_recording(made / "recording", motions, sensor)
        words = ["recording", "train", str(made / "recording"), "--out", str(made), "--estimators", "ridge"]
        done = subprocess.run(
            [sys.executable, "-m", "palpate", *words], cwd=SOURCE.parent, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr

    drawing = inspect.getsource(drawn_tactip)
    shutil.copytree(stored_folder("learnt", [drawing], learn), folder, dirs_exist_ok=True)
    return folder


def copy_artefacts(study: Path, folder: Path) -> None:
    """Copy the artefacts of a study to the store of a folder, where a run of the study finds them."""
    shutil.copytree(study_results(study.read_text()) / "store", folder / "store")


def stored(kind: str, inputs: Iterable[Any], make: Callable[[], Any]) -> Any:
    """Return what `make` returns, computed once for each kind, inputs and state of the source."""
    path = _path(kind, inputs)
    with _locked(path):
        if not path.exists():
            draft = path.with_suffix(f".{os.getpid()}")
            draft.write_bytes(pickle.dumps(make()))
            draft.rename(path)
    return _load(path)


def stored_folder(kind: str, inputs: Iterable[Any], make: Callable[[Path], None]) -> Path:
    """Folder that `make` filled, once for each kind, inputs and state of the source; only to be read."""
    path = _path(kind, inputs)
    with _locked(path):
        if not path.exists():
            draft = path.with_suffix(f".{os.getpid()}")
            draft.mkdir()
            make(draft)
            draft.rename(path)
    return path


@cache
def _compile_kernels() -> None:
    """Solve a small press: workers that begin together wait here for one of them to compile."""
    wall = WallSpec(tilt_deg=4.0, contact=0.5, depth=0.1, depth_step=0.1)
    solver = SolverSpec(derivatives=twins.TWIN_DERIVATIVES)
    with _locked(_folder("press") / "kernels"):
        mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=4))
        fea.solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), wall, solver)


@cache
def _load(path: Path) -> Any:
    return pickle.loads(path.read_bytes())


def _path(kind: str, inputs: Iterable[Any]) -> Path:
    digest = hashlib.sha256(kind.encode())
    for part in inputs:
        digest.update(b"\0" + (part.tobytes() if hasattr(part, "tobytes") else str(part).encode()))
    return _folder(kind) / f"{kind}-{digest.hexdigest()[:32]}"


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    with path.with_name(path.name + ".lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@cache
def _folder(kind: str) -> Path:
    chosen = os.environ.get("PALPATE_TEST_STORE")
    cached = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "palpate-tests"
    folder = (Path(chosen) if chosen else cached) / source_stamp(kind)
    folder.mkdir(parents=True, exist_ok=True)
    os.utime(folder)
    for other in folder.parent.iterdir():
        if time.time() - other.stat().st_mtime > OLD_S:
            shutil.rmtree(other, ignore_errors=True)
    return folder


def _mesh_parts(mesh: Mesh) -> tuple[Any, ...]:
    return _data(mesh.skin.spec_data), mesh.spec.model_dump_json(), mesh.pole, mesh.nodes, mesh.cells


def _spec_parts(spec: Any) -> tuple[str, str]:
    return f"{type(spec).__module__}.{type(spec).__qualname__}", spec.model_dump_json()


def _data(value: Any) -> str:
    return json.dumps(value, sort_keys=True)
