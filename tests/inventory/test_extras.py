"""Each extra works alone: with the libraries of no other extra, the command that it is for does its work.

A process may import only the distributions that the package and one extra ask for, directly or through others; every
other one is as if it were not installed.
"""

import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from needs import EXTRAS, needs

ROOT = Path(__file__).parents[2]
DATA = ROOT / "examples" / "data"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PRESSES = """
from palpate.datasets import DatasetSpec, generate_dataset
from palpate.camera import build_camera
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
skin = build_skin(DomeSpec())
mesh, material = mesh_skin(skin, MeshSpec(cells=4)), get_material("neo-hooke:0.02")
presses = [solve_press(mesh, material, WallSpec(tilt_deg=t, depth=3, depth_step=1)) for t in (0.0, 4.0, 8.0)]
dataset = generate_dataset(presses, place_markers(skin, MarkerSpec(count=7)), build_camera(),
                           DatasetSpec(n_presses=30, max_tilt_deg=8))
"""
GRID = "import sys; sys.path[:0] = ['{root}/tests']; from results import PAPER\n"
PROGRAMS = {
    "": "from palpate.cli import main; main('press --cells 4 --depth 2 --step 1 --json'.split())",
    "learn": PRESSES
    + "from palpate.learn import TrainingSpec, train; print(train(dataset, TrainingSpec(epochs=2), 0).members)",
    "predict": PRESSES
    + "from palpate.learn import fit_ridge, open_predictor, write_estimator; from pathlib import Path\n"
    "write_estimator(Path('m.onnx'), fit_ridge(dataset))\n"
    "print(open_predictor(Path('m.onnx')).predict(dataset.images_px[:2]).pose)",
    "parquet": "from palpate.study import evaluate_grid, export_grid; from pathlib import Path\n"
    + GRID
    + "export_grid(Path('grid.parquet'), evaluate_grid(PAPER[:4]))",
    "cad": "from palpate.cli import main; main('specimens --out molds --json'.split())",
    "viz": "from palpate.cli import main; main('press --cells 4 --depth 2 --step 1 --export out'.split())",
    "cluster": "from palpate.study.cluster import ClusterWorkers\n"
    "if __name__ == '__main__':\n    pool = ClusterWorkers('local:1')\n"
    "    print(pool.size)\n    pool.shutdown()",
    "web": "import palpate.viewer.server; from nicegui import ui; print(ui.label)",
    "vision": "from palpate.cli import main; main('find {data}/recording --json'.split())",
    "davis": "import dv_processing; print(dv_processing.__version__)",
    "av": "from palpate.core import load_extra; load_extra('av', 'av', 'PyAV')",
    "zarr": "from palpate.core import load_extra; load_extra('zarr', 'zarr', 'Zarr')",
    "ros": "from palpate.sensor.write_bag import Bag; from pathlib import Path; Bag(Path('bag')).close()",
    "ros2": "from palpate.core import load_extra; load_extra('websockets.sync.client', 'ros2')",
    "ur": "from palpate.core import load_extra; load_extra('rtde_control', 'ur'); load_extra('rtde_receive', 'ur')",
    "docs": "import sphinx, myst_parser, pydata_sphinx_theme, latex2mathml, pytest, hypothesis",
}
"""Extra → a program that needs it; without any, what the core does."""
BLOCK = """
import sys
class Finder:
    def __init__(self, finder):
        self.finder = finder
    def __getattr__(self, name):
        return getattr(self.finder, name)
    def find_spec(self, name, *others):
        return None if name.partition(".")[0] in {blocked} else self.finder.find_spec(name, *others)
sys.meta_path[:] = map(Finder, sys.meta_path)
"""


def distributions_of(requirements: list[str], extras: set[str]) -> set[str]:
    """Normalised names of the distributions that requirements ask for, with all that those ask for."""
    found: set[str] = set()
    todo = [(Requirement(text), extras) for text in requirements]
    while todo:
        requirement, asked = todo.pop()
        name = normal(requirement.name)
        wanted = requirement.marker is None or any(
            requirement.marker.evaluate({"extra": one}) for one in (asked or {""})
        )
        if not wanted or (name in found and not requirement.extras):
            continue
        found.add(name)
        try:
            further = metadata.requires(name) or []
        except metadata.PackageNotFoundError:
            continue
        todo += [(Requirement(text), set(requirement.extras)) for text in further]
    return found


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_every_extra_has_a_program() -> None:
    assert set(PROGRAMS) == {*PROJECT["optional-dependencies"], ""} - {"all", "test"}


@pytest.mark.slow
@pytest.mark.parametrize("extra", PROGRAMS)
def test_an_extra_works_alone(extra: str, tmp_path: Path) -> None:
    for module in EXTRAS.get(extra, ()):
        needs(module)
    asked = PROJECT["dependencies"] + (PROJECT["optional-dependencies"][extra] if extra else [])
    allowed = distributions_of(asked, set())
    tops = metadata.packages_distributions()
    blocked = {top for top, owners in tops.items() if not {normal(one) for one in owners} & allowed}
    blocked -= {"palpate", "_virtualenv", "pip", "setuptools", "packaging"}
    program = tmp_path / "program.py"
    program.write_text(
        BLOCK.format(blocked=blocked) + PROGRAMS[extra].replace("{data}", str(DATA)).replace("{root}", str(ROOT))
    )
    done = subprocess.run(
        [sys.executable, str(program)],
        cwd=tmp_path,
        env={"PATH": "", "HOME": str(tmp_path), "PYTHONPATH": str(ROOT / "src"), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-3000:]
