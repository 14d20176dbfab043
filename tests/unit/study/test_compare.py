from dataclasses import replace

import pytest

from errors import refused
from palpate.study import compare_grids, evaluate_grid
from palpate.study.compare_grids import RECORDED, UNRECORDED, VARIES
from results import FIRST, make_design

SPEC = {"obstacle": {"contact": "no-slip"}, "dataset": {"seed": 4, "poses": "disc"}}


def grid_of(*designs, **changes):
    return evaluate_grid([replace(design, **changes) for design in designs])


def test_a_grid_is_the_same_as_itself():
    comparison = compare_grids(grid_of(*FIRST, spec=SPEC), grid_of(*FIRST, spec=SPEC))
    assert len(comparison.rows) == len(FIRST)
    assert {row["rmse_deg_ratio"] for row in comparison.rows} == {1.0}
    assert comparison.differences == comparison.only_first == comparison.only_second == ()


def test_designs_are_matched_whatever_their_order():
    one = evaluate_grid([make_design(markers=7), make_design(height=10.0)])
    two = evaluate_grid([make_design(height=10.0), make_design(markers=91)])
    comparison = compare_grids(one, two)
    assert [(row["height_mm"], row["markers"]) for row in comparison.rows] == [(10.0, 169)]
    assert [row["markers"] for row in comparison.only_first] == [7]
    assert [row["markers"] for row in comparison.only_second] == [91]


def test_ratio_is_second_over_first_and_empty_without_both():
    good = make_design()
    clean = replace(
        good.clean,
        by_axis={**good.clean.by_axis, "angle": replace(good.clean.pooled, rmse=2 * good.clean.pooled.rmse)},
    )
    (row,) = compare_grids(grid_of(good), grid_of(good, clean=clean)).rows
    assert row["rmse_deg_ratio"] == pytest.approx(2.0)
    assert row["max_error_deg_ratio"] == 1.0
    (row,) = compare_grids(grid_of(good), evaluate_grid([make_design(failure="stopped")])).rows
    assert (row["rmse_deg_a"], row["rmse_deg_b"], row["rmse_deg_ratio"]) == (good.clean.pooled.rmse, None, None)


def with_spread(rmse: float, *spread: float | None, markers: tuple[int, ...] = (7, 37, 91)):
    """A grid of three designs of one RMSE, each with its spread over the repeats."""
    grid = evaluate_grid([make_design(markers=count) for count in markers])
    rows = (
        {**row, "rmse_deg": rmse, "rmse_spread_deg": each} for row, each in zip(grid.designs, spread, strict=True)
    )
    return replace(grid, designs=tuple(rows))


def test_rows_that_moved_beyond_their_spread_are_told():
    """By 0.04°, where training again makes 0.03° and 0.005°; the third has no repeats in either grid."""
    comparison = compare_grids(with_spread(0.24, 0.03, 0.005, None), with_spread(0.20, 0.03, None, None))
    moved = {row["markers"]: row["moved"] for row in comparison.rows}
    assert moved[7] == pytest.approx(-0.04 / (0.03 * 2**0.5))
    assert moved[37] == pytest.approx(-0.04 / (0.005 * 2**0.5))
    assert moved[91] is None
    assert [row["markers"] for row in comparison.moved] == [37]


def test_spec_seeds_and_versions_that_differ_are_named():
    other = {"obstacle": {"contact": "frictionless"}, "dataset": {"seed": 5, "poses": "disc"}}
    first = grid_of(make_design(), spec=SPEC, seed=1, versions={"fea": "1", "platform": "Linux x86_64"})
    second = grid_of(make_design(), spec=other, seed=2, versions={"fea": "2", "platform": "Linux x86_64"})
    found = {item.name: (item.first, item.second) for item in compare_grids(first, second).differences}
    assert found == {
        "seed": ("1", "2"),
        "dataset seed": ("4", "5"),
        "version fea": ("1", "2"),
        "spec obstacle.contact": ("no-slip", "frictionless"),
    }


def test_what_differs_between_the_designs_of_one_grid_is_named_as_varying():
    mixed = evaluate_grid([replace(make_design(), seed=1), replace(make_design(markers=7), seed=2)])
    (seed,) = compare_grids(
        mixed, evaluate_grid([replace(make_design(markers=m), seed=1) for m in (169, 7)])
    ).differences
    assert (seed.first, seed.second) == (VARIES, "1")


def test_a_grid_without_specs_gives_one_line_not_fifty():
    old = evaluate_grid([make_design()])
    old = replace(old, designs=tuple({**row, "spec": None} for row in old.designs))
    (spec,) = compare_grids(grid_of(make_design(), spec=SPEC), old).differences
    assert (spec.name, spec.first, spec.second) == ("spec", RECORDED, UNRECORDED)


@pytest.mark.parametrize(
    ("metric", "says"), [("colour", ("column-unknown", "colour")), ("shape", ("metric-is-text", "shape"))]
)
def test_a_metric_that_is_none_is_refused(metric, says):
    with refused(*says):
        compare_grids(evaluate_grid(FIRST), evaluate_grid(FIRST), [metric])


@pytest.mark.parametrize(("off", "moved"), [(2.0, 0), (2.0001, 1), (-2.0001, 1), (0.0, 0)])
def test_a_row_has_moved_beyond_two_standard_deviations_either_way(off, moved):
    comparison = compare_grids(grid_of(*FIRST), grid_of(*FIRST))
    rows = tuple({**row, "moved": off if number == 0 else None} for number, row in enumerate(comparison.rows))
    assert len(replace(comparison, rows=rows).moved) == moved


@pytest.mark.parametrize(("second", "moved"), [(0.20, -float("inf")), (0.28, float("inf")), (0.24, 0.0)])
def test_without_any_spread_every_difference_has_moved(second, moved):
    comparison = compare_grids(with_spread(0.24, 0.0, 0.0, 0.0), with_spread(second, 0.0, 0.0, 0.0))
    assert {row["moved"] for row in comparison.rows} == {moved}
