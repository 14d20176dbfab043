"""A press is known by what it is, whoever solves it: what one has solved the others find."""

from pathlib import Path

from palpate.bench import Bench, Deviation, VirtualBenchSpec
from palpate.bench.bench import _mesh_spec, _press_recipe, _wall
from palpate.camera import CameraSpec
from palpate.core import ArtefactStore
from palpate.deck import CalculixSpec
from palpate.design import DomeSpec, MarkerSpec
from palpate.fea import Branch
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.optimise.prove import CalculixTask
from palpate.study import PressTask

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")


def tried(tmp_path: Path, branch: Branch, **chosen: object) -> tuple[Bench, PressTask, str]:
    """A bench, the same press as a task of a study, and the key by which the bench knows it."""
    spec = VirtualBenchSpec(**chosen)
    bench = Bench(spec, DomeSpec(), MarkerSpec(count=37), ECOFLEX, CameraSpec(), Path("m"), ArtefactStore(tmp_path))
    unit = Deviation(friction=1.0)
    wall, mesh = _wall(bench, unit, 3.0, branch), _mesh_spec(bench, unit, branch)
    task = PressTask(DomeSpec(), mesh, ECOFLEX, wall, SolverSpec(), branch)
    return bench, task, _press_recipe(bench, unit, 3.0, branch).key


def test_bench_and_study_share_a_press(tmp_path: Path) -> None:
    for branch in Branch:
        _, task, key = tried(tmp_path, branch)
        assert task.recipe.key == key


def test_bench_and_validation_share_a_press_by_calculix(tmp_path: Path) -> None:
    _, task, key = tried(tmp_path, Branch.FLAT, solver="calculix")
    other = CalculixTask(task).recipe
    assert other.key == key
    assert other.key != task.recipe.key
    assert other.spec["solver"] == {"calculix": CalculixSpec().model_dump(mode="json")}
