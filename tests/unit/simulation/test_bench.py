"""The virtual bench on coarse presses: the truth is known, so the chain can be held against it."""

import csv
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from errors import check_values, refused
from needs import needs_program
from palpate.calibration import Deviation, ToleranceSpec
from palpate.camera import RenderSpec
from palpate.core.report import page_markdown
from palpate.simulation import run_bench, run_budget, run_unit_trial, write_bench, write_budget
from palpate.simulation.budget import BudgetLine, recommend_randomisation, total
from palpate.simulation.result import bench_page, pool_units, score_unit
from palpate.simulation.run_trial import solve_unit_presses, unit_tilts
from palpate.simulation.spec import VirtualBenchSpec
from palpate.simulation.trial import COLUMNS, collect_estimates, covered_share
from small_chain import TWIN_CELLS, TWIN_DEPTH, rms, small_bench, write_small_model, write_small_twin


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    return small_bench(folder, write_small_model(folder / "m.onnx"))


@pytest.fixture(scope="module")
def nominal(bench):
    return run_unit_trial(bench, Deviation())


def change(unit, other):
    return (unit.corrected() - unit.truth) - (other.corrected() - other.truth)


def test_the_nominal_unit_is_read_from_degraded_images(nominal):
    errors = nominal.corrected() - nominal.truth
    assert not nominal.failure
    assert len(errors) == 2 * 2 * 4
    assert rms(errors[:, :2]) < 0.5
    assert rms(errors[:, 2]) < 0.2
    assert np.hypot(*nominal.truth[:, :2].T).max() <= 8.0


def test_a_played_unit_is_not_played_again(bench, nominal, tmp_path):
    shutil.copytree(bench.store.root, tmp_path / "store")
    shutil.rmtree(tmp_path / "store" / "press")
    again = run_unit_trial(replace(bench, store=type(bench.store)(tmp_path / "store")), Deviation())
    assert not (tmp_path / "store" / "press").exists()
    assert np.array_equal(again.estimates, nominal.estimates)
    assert again.zero == nominal.zero


def test_the_presses_are_at_other_tilts_and_on_another_mesh_for_every_unit(bench):
    tilts = [unit_tilts(bench.spec, unit) for unit in range(3)]
    assert len({tuple(row) for row in tilts}) == 3
    assert all(0 <= low < 4 <= high < 8 for low, high in tilts)
    finer = replace(bench, spec=bench.spec.model_copy(update={"cells": None, "tilts": 1, "depth": 0.5}))
    press = next(solve_unit_presses(finer, Deviation()))
    assert press.mesh.spec.cells > 16


def test_what_the_robot_takes_for_first_touch_does_not_matter_after_one_press(bench, nominal):
    off = run_unit_trial(bench, Deviation(depth_zero=1.0))
    assert off.zero.offset == pytest.approx(1.0 + nominal.zero.offset, abs=1e-9)
    assert np.abs(change(off, nominal)).max() < 1e-9
    blind = replace(bench, spec=bench.spec.model_copy(update={"zero": False}))
    raw = run_unit_trial(blind, Deviation(depth_zero=1.0))
    assert raw.zero is None
    assert np.mean(raw.corrected() - raw.truth, axis=0)[2] == pytest.approx(-1.0, abs=0.15)


def test_a_dome_seated_at_a_slant_is_read_wrong_by_as_much(bench, nominal):
    slant = run_unit_trial(bench, Deviation(seating_x_deg=0.3))
    assert np.mean(change(slant, nominal), axis=0) == pytest.approx([-0.3, 0.0, 0.0], abs=1e-9)


def test_a_dome_of_softer_silicone_is_read_the_same(bench, nominal):
    soft = run_unit_trial(bench, Deviation(modulus=-0.3))
    assert np.abs(change(soft, nominal)[:, :2]).max() < 0.02


def test_a_unit_whose_dots_cannot_be_named_is_a_failure_with_a_reason(bench):
    lost = run_unit_trial(bench, Deviation(missing=0.9))
    assert lost.failure
    result = score_unit(1, lost)
    assert result.scores == ()
    assert not result.meets_paper


def test_the_tables_name_seed_versions_and_tolerances(bench, tmp_path):
    quick = replace(
        bench, spec=bench.spec.model_copy(update={"tolerance": ToleranceSpec(friction_min=0, thickness=0)})
    )
    results = list(run_bench(quick))
    write_bench(tmp_path, quick, results)
    report = json.loads((tmp_path / "bench.json").read_text())
    assert report["made_by"]["palpate"]
    assert report["spec"]["seed"] == 0
    assert [unit["unit"] for unit in report["units"]] == [0, 1]
    assert report["as_good_as_the_paper"]["of"] == 1
    with (tmp_path / "bench.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["component"] for row in rows[:3]] == ["roll deg", "pitch deg", "depth mm"]
    page = (tmp_path / "bench.md").read_text()
    assert "the paper's sensor | roll deg | 0.58 | 0.49 | 1.62 | 0.54" in page


def test_what_known_presses_told_is_held_against_what_the_unit_is(tmp_path):
    tolerance = ToleranceSpec(thickness=0.1, friction_min=0.6, friction_max=0.9)
    bench = small_bench(
        tmp_path,
        write_small_twin(tmp_path / "twin.h5"),
        calibration_presses=2,
        tilts=1,
        azimuths=1,
        tolerance=tolerance,
        depth=TWIN_DEPTH,
        cells=TWIN_CELLS,
    )
    results = list(run_bench(bench))
    unit = results[1].trial
    assert not unit.failure
    learnt = {each.name: each for each in unit.parameters}
    assert learnt["thickness"].truth == unit.deviation.thickness != 0
    assert learnt["thickness"].prior_sd == pytest.approx(0.1 / np.sqrt(3))
    slips = [each for each in unit.parameters if each.name.startswith("1/friction")]
    assert [each.truth for each in slips] == 2 * [1 / unit.deviation.friction]
    assert rms(np.array([each.mean - each.truth for each in slips])) < 0.3  # a coarse mesh of the same cells
    force, off, half = collect_estimates([unit], "force_n")
    assert (force > 0.02).all()
    assert rms(off / force) < 0.1
    assert 0.3 < covered_share(off, half) <= 1.0
    write_bench(tmp_path / "out", bench, results)
    page = (tmp_path / "out" / "bench.md").read_text()
    assert "| thickness | 1 |" in page
    assert f"| force_n | {len(force)} |" in page
    assert (
        json.loads((tmp_path / "out" / "bench.json").read_text())["units"][1]["parameters"][0]["name"] == "offset_x"
    )


def test_the_budget_tells_what_every_imperfection_costs_alone(bench, tmp_path):
    only = {"seating_tilt_deg": 0.3, "depth_zero": 1.0, "print_shift": 0.3}
    none = {name: 0 for name in ToleranceSpec.model_fields if name not in only}
    tolerance = ToleranceSpec(**none, **only)
    chosen = replace(bench, spec=bench.spec.model_copy(update={"tolerance": tolerance, "tilts": 1, "azimuths": 1}))
    lines = {line.name: line for line in run_budget(chosen)}
    assert set(lines) == {"model", "images", "print_shift", "seating_tilt_deg", "depth_zero", "touch_unknown"}
    assert lines["seating_tilt_deg"].angle_deg == pytest.approx(0.3)
    assert lines["depth_zero"].depth < 1e-9
    assert lines["touch_unknown"].depth == pytest.approx(1.0)
    assert lines["images"].angle_deg < lines["model"].angle_deg
    assert total(list(lines.values())) > 0.3
    write_budget(tmp_path, chosen, list(lines.values()))
    assert {path.name for path in tmp_path.iterdir()} == {"budget.json", "budget.csv", "budget.md", "budget.png"}


def test_only_what_costs_much_and_can_be_learned_is_recommended():
    costs = {"model": 0.05, "seating_tilt_deg": 0.4, "friction_min": 0.3, "marker_position": 0.01}
    lines = [BudgetLine(name, name, "", cost, cost, 0.0, 1) for name, cost in costs.items()]
    assert recommend_randomisation(lines, ToleranceSpec()) == {"friction_min": 0.8}
    assert total(lines) == pytest.approx(np.sqrt(sum(cost**2 for cost in costs.values())))


def test_flagged_images_are_counted_apart(bench, nominal):
    images = nominal.images.copy()
    images[::3, COLUMNS.index("flagged")] = 1.0
    images[::3, COLUMNS.index("rx_deg_read")] += 30.0
    unit = score_unit(1, replace(nominal, images=images))
    all_images, trusted = pool_units([unit]), pool_units([unit], trusted=True)
    assert trusted[0].images == all_images[0].images - len(images[::3])
    assert all_images[0].errors.max > 25 > trusted[0].errors.max
    check_values(page_markdown(bench_page(bench, [unit])), len(images[::3]))


def test_units_that_cannot_be_inverted_are_refused(bench):
    with refused("inverted-exceed-units", "3", "2"):
        VirtualBenchSpec(units=2, inverted=3)
    with refused("inverted-needs-own-solver", "calculix"):
        VirtualBenchSpec(inverted=1, solver="calculix")
    shallow = replace(bench, spec=bench.spec.model_copy(update={"units": 1, "inverted": 1, "tilts": 1, "depth": 2.5}))
    played = run_unit_trial(shallow, replace(Deviation(), unit=1))
    check_values(played.failure, "2.5 mm")


def test_a_model_that_is_not_there_is_refused(bench, tmp_path):
    with refused("file-unreadable"):
        run_unit_trial(replace(bench, model=tmp_path / "none.onnx"), Deviation())


def test_clean_images_are_another_bench(bench):
    clean = replace(bench, spec=bench.spec.model_copy(update={"render": RenderSpec()}))
    assert not np.array_equal(
        run_unit_trial(clean, Deviation()).estimates, run_unit_trial(bench, Deviation()).estimates
    )


@pytest.mark.slow
@needs_program("calculix-ccx")
def test_calculix_as_the_solver_gives_about_the_same_readings(bench):
    quick = bench.spec.model_copy(update={"tilts": 1, "contact": "frictionless"})
    units = [
        run_unit_trial(replace(bench, spec=quick.model_copy(update={"solver": solver})), Deviation())
        for solver in ("palpate", "calculix")
    ]
    assert not units[1].failure
    assert 0 < np.abs(change(*units)[:, :2]).max() < 0.6  # a coarse mesh of other elements
