"""A press is known by what it is, whoever solves it: what one has solved the others find."""

from dataclasses import replace
from pathlib import Path

from palpate.calibration import Deviation, sample_deviation
from palpate.core import ArtefactStore
from palpate.design import Design, MarkerSpec
from palpate.fea import Branch, CalculixSpec
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.optimise.validate_designs import CalculixTask, UnitTrialTask
from palpate.simulation import VirtualBench, VirtualBenchSpec, unit_recipe
from palpate.simulation.run_trial import _mesh_spec, _press_recipe, _wall
from palpate.study import PressTask, TwinTask

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")


def tried(tmp_path: Path, branch: Branch, **chosen: object) -> tuple[VirtualBench, PressTask, str]:
    """A bench, the same press as a task of a study, and the key by which the bench knows it."""
    spec = VirtualBenchSpec(**chosen)
    bench = VirtualBench(
        spec, Design(markers=MarkerSpec(count=37), material=ECOFLEX), Path("m"), ArtefactStore(tmp_path)
    )
    unit = Deviation(friction=1.0)
    wall, mesh = _wall(bench, unit, 3.0, branch), _mesh_spec(bench, unit, branch)
    task = PressTask(Design(material=ECOFLEX), mesh, wall, SolverSpec(), branch)
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
    assert other.spec["solver"]["calculix"] == CalculixSpec().model_dump(mode="json")
    assert len(other.spec["solver"]["deck"]) == 64


def test_a_unit_of_the_validation_is_one_artefact(tmp_path: Path) -> None:
    """What a search's validation stores of a unit is what the bench stores of it, known before its model is made."""
    bench, press, _ = tried(tmp_path, Branch.FLAT)
    twin = TwinTask((press,))
    task = UnitTrialTask(twin, Design(markers=MarkerSpec(count=37)), bench.spec, 2)
    unit = sample_deviation(bench.spec.tolerance, bench.spec.seed, 2)
    assert task.recipe.kind == "unit"
    assert task.recipe.key == unit_recipe(replace(bench, model_key=twin.recipe.key), unit).key
    assert len({replace(task, unit=number).recipe.key for number in (1, 2, 3)}) == 3
    assert not list(tmp_path.iterdir())
