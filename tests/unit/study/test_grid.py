import csv
import json
import warnings
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from errors import refused
from palpate.study import (
    SpecificationGrid,
    cut_depth_panels,
    cut_panels,
    evaluate_grid,
    read_grid,
    rows_for_design,
    write_grid,
)
from palpate.study.grid import column_unit
from results import FIRST, PAPER, leave_out_pictures, make_design

PUBLISHED = Path(__file__).parents[3] / "docs" / "results"
PROMISED = {
    "height_mm",
    "thickness_mm",
    "markers",
    "rmse_deg",
    "max_error_deg",
    "rmse_jitter_deg",
    "max_error_jitter_deg",
    "travel_mm",
    "peak_stress_mpa",
    "force_n",
    "presses",
    "samples",
    "seed",
    "dataset_seed",
    "learning_seed",
    "spec",
    "repeats",
    "rmse_spread_deg",
    "bound_deg",
    "bound_pitman_deg",
    "rmse_over_bound",
    "estimator_key",
}
PICTURES = (
    "heat_map_rmse",
    "heat_map_max_error",
    "heat_map_rmse_jitter",
    "heat_map_max_error_jitter",
    "marker_travel",
    "error_by_depth",
    "error_by_depth_jitter",
)


def test_a_row_holds_the_figures_of_its_design():
    design = make_design()
    row = evaluate_grid([design]).designs[0]
    assert set(row) >= PROMISED
    assert row["rmse_deg"] == design.clean.pooled.rmse
    assert row["max_error_jitter_deg"] == design.jittered.pooled.max
    assert row["bias_ry_jitter_deg"] == design.jittered.by_axis["ry"].bias
    assert row["max_depth_mm"] == design.clean.by_axis["depth"].max
    assert (row["presses"], row["samples"], row["dropped"], row["seed"]) == (2, 460, 20, 3)
    assert (row["presses_flat"], row["presses_inverted"]) == (1, 1)
    assert row["dropped_reasons"] == "wall reached the clamped rim: 20"
    assert row["press_key"] == "aa bb"
    assert json.loads(row["versions"]) == {"palpate": "0.1.0", "fea": "1"}
    assert row["rmse_spread_deg"] == pytest.approx(0.1)
    assert (row["repeats"], row["dataset_seed"], row["learning_seed"]) == (3, 4, None)


def test_a_row_holds_the_limit_and_how_near_the_error_comes():
    design = make_design()
    row = evaluate_grid([design]).designs[0]
    assert row["bound_deg"] == pytest.approx(np.sqrt((1.2**2 + 0.2**2) / 2))
    assert row["bound_pitman_deg"] == pytest.approx(np.sqrt((0.7**2 + 0.1**2) / 2))
    assert row["rmse_over_bound"] == pytest.approx(row["rmse_jitter_deg"] / row["bound_deg"])


def test_the_table_by_depth_holds_errors_and_limits():
    design = make_design()
    shallow, deep = rows_for_design(evaluate_grid([make_design(markers=7), design]).by_depth, 1)
    assert (shallow["depth_mm"], deep["depth_mm"]) == (2.4, 8.0)
    assert (shallow["bound_deg"], deep["bound_floor_deg"]) == (1.2, 0.05)
    assert deep["rmse_deg"] == design.clean.by_depth[1].pooled.rmse
    assert deep["max_error_jitter_deg"] == design.jittered.by_depth[1].pooled.max
    assert deep["rmse_over_bound"] == pytest.approx(design.jittered.by_depth[1].pooled.rmse / 0.2)
    assert deep["validation_samples"] == design.clean.by_depth[1].images


def test_a_design_without_an_estimator_still_has_its_limit():
    row = evaluate_grid([make_design(failure="stopped"), make_design()]).designs[0]
    assert row["bound_deg"] == pytest.approx(np.sqrt((1.2**2 + 0.2**2) / 2))
    assert row["rmse_over_bound"] is None


def test_the_table_by_tilt_holds_the_errors_of_every_interval():
    (row,) = evaluate_grid([make_design()]).by_tilt
    assert (row["design"], row["tilt_from_deg"], row["tilt_to_deg"]) == (0, 4, 6)
    assert row["rmse_deg"] == make_design().clean.by_tilt[0].pooled.rmse
    assert row["max_error_jitter_deg"] == make_design().jittered.by_tilt[0].pooled.max
    assert row["validation_samples"] == 4


def test_presses_of_one_tilt_are_told_apart_by_their_azimuth():
    design = make_design()
    turned = tuple(replace(press, azimuth_deg=azimuth) for press in design.presses for azimuth in (0.0, 90.0))
    rows = evaluate_grid([replace(design, presses=turned)]).presses
    assert [(row["tilt_deg"], row["azimuth_deg"]) for row in rows] == [(0, 0), (0, 90), (12, 0), (12, 90)]
    assert all("azimuth_deg" not in row for row in evaluate_grid([design]).presses)


def test_the_table_of_presses_says_how_each_ended():
    _, steep = evaluate_grid([make_design()]).presses
    assert (steep["design"], steep["tilt_deg"], steep["branch"]) == (0, 12.0, "inverted")
    assert (steep["ended"], steep["ended_depth_mm"]) == ("wall reached the clamped rim", 7.1)


def test_every_row_has_every_column_even_where_the_chain_broke():
    broken = make_design(thickness=3.0, failure="press H20 T3 tilt 0: not converged")
    grid = evaluate_grid([broken, make_design()])
    assert all(tuple(row) == grid.columns for row in grid.designs)
    assert grid.designs[0]["rmse_deg"] is None
    assert grid.designs[0]["travel_mm"] is None
    assert grid.designs[0]["failure"] == "press H20 T3 tilt 0: not converged"
    assert grid.designs[0]["presses"] == 2


def test_depths_that_only_one_design_reached_stay_empty_elsewhere():
    shallow = make_design(height=10.0)
    clean = replace(shallow.clean, by_depth=shallow.clean.by_depth[:1])
    grid = evaluate_grid([replace(shallow, clean=clean), make_design()])
    assert [row["rmse_deg"] is None for row in grid.by_depth] == [False, True, False, False]
    assert np.isnan(cut_depth_panels(grid)[0].values).tolist() == [[False, True], [False, False]]


def test_depths_close_together_keep_a_row_each():
    design = make_design()
    shallow, deep = design.clean.by_depth
    by_depth = (replace(shallow, depth_mm=2.4), replace(deep, depth_mm=2.45))
    grid = evaluate_grid([replace(design, clean=replace(design.clean, by_depth=by_depth))])
    found = {row["depth_mm"]: row["rmse_deg"] for row in grid.by_depth}
    assert found == {2.4: shallow.pooled.rmse, 2.45: deep.pooled.rmse, 8.0: None}


def test_a_row_with_other_columns_or_of_no_design_is_refused():
    with pytest.raises(ValueError):  # noqa: PT011
        SpecificationGrid(designs=({"markers": 7}, {"seed": 7}))
    with pytest.raises(ValueError):  # noqa: PT011
        SpecificationGrid(designs=({"markers": 7},), by_depth=({"design": 1, "depth_mm": 2.0},))


def test_designs_that_are_kept_keep_their_tables():
    grid = evaluate_grid(FIRST)
    some = grid.select([grid.designs[5], grid.designs[2]])
    assert [row["markers"] for row in some.designs] == [37, 91]
    for table in ("by_depth", "by_tilt", "presses"):
        for new, old in ((0, 5), (1, 2)):
            kept = [{**row, "design": old} for row in rows_for_design(getattr(some, table), new)]
            assert tuple(kept) == rows_for_design(getattr(grid, table), old)


@pytest.mark.parametrize(
    ("column", "unit"), [("rmse_deg", "deg"), ("travel_mm", "mm"), ("force_n", "N"), ("markers", "")]
)
def test_a_columns_suffix_is_its_unit(column, unit):
    assert column_unit(column) == unit


def test_folder_gives_the_same_grid_back(tmp_path, monkeypatch):
    leave_out_pictures(monkeypatch)
    grid = evaluate_grid([*FIRST, make_design(thickness=4.0, failure="stopped")])
    write_grid(tmp_path / "new", grid)
    assert read_grid(tmp_path / "new") == grid


def test_csv_has_one_line_a_design_and_empty_cells_for_nothing(tmp_path, monkeypatch):
    leave_out_pictures(monkeypatch)
    write_grid(tmp_path, evaluate_grid([make_design(), make_design(markers=7, failure="stopped")]))
    with (tmp_path / "grid.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["H20 T2, 169 markers", "H20 T2, 7 markers"]
    assert [row["markers"] for row in rows] == ["169", "7"]
    assert float(rows[0]["rmse_deg"]) == make_design().clean.pooled.rmse
    assert rows[1]["rmse_deg"] == ""


def test_csv_is_short_enough_to_read_and_the_other_tables_stand_beside_it(tmp_path, monkeypatch):
    leave_out_pictures(monkeypatch)
    write_grid(tmp_path, evaluate_grid(FIRST))
    tables = {}
    for name in ("grid", "by_depth", "by_tilt", "presses"):
        with (tmp_path / f"{name}.csv").open(newline="") as file:
            tables[name] = list(csv.DictReader(file))
    assert len(tables["grid"][0]) <= 30
    assert [len(rows) for rows in tables.values()] == [8, 16, 8, 16]
    assert tables["by_depth"][3]["name"] == tables["grid"][1]["name"]
    assert (tables["presses"][1]["design"], tables["presses"][1]["branch"]) == ("0", "inverted")


def test_json_names_units_and_has_no_value_that_is_not_a_number(tmp_path, monkeypatch):
    leave_out_pictures(monkeypatch)
    write_grid(tmp_path, evaluate_grid([make_design(failure="stopped")]))
    content = json.loads((tmp_path / "grid.json").read_text(), parse_constant=lambda word: pytest.fail(word))
    assert content["units"]["travel_mm"] == "mm"


def test_pictures_are_written_and_the_same_grid_gives_the_same_bytes(tmp_path):
    grid = evaluate_grid(FIRST[3:5])  # two domes, two layouts, and cells without a design
    for folder in ("one", "two"):
        write_grid(tmp_path / folder, grid)
    for name in PICTURES:
        png, svg = (tmp_path / "one" / f"{name}.{ending}" for ending in ("png", "svg"))
        assert png.read_bytes()[:4] == b"\x89PNG"
        assert b"<svg" in svg.read_bytes()[:1000]
        assert svg.read_bytes() == (tmp_path / "two" / svg.name).read_bytes()


def test_panels_put_each_figure_at_its_height_and_thickness():
    panels = cut_panels(evaluate_grid(PAPER[::-1]), "rmse_deg")
    assert [panel.title for panel in panels] == ["7 markers", "37 markers", "91 markers", "169 markers"]
    assert panels[3].heights_mm == (10.0, 20.0, 30.0)
    assert panels[3].values[1, 2] == make_design(20.0, 3.0, 169).clean.pooled.rmse
    assert panels[0].values[2, 0] == make_design(30.0, 1.0, 7).clean.pooled.rmse


def test_designs_that_are_missing_leave_empty_cells():
    values = cut_panels(evaluate_grid([make_design(10.0, 1.0), make_design(20.0, 2.0)]), "rmse_deg")[0].values
    assert np.isnan(values).tolist() == [[False, True], [True, False]]


def test_two_layouts_of_as_many_markers_get_a_panel_each():
    panels = cut_panels(evaluate_grid([make_design(), make_design()]), "rmse_deg")
    assert [panel.title for panel in panels] == ["169 markers", "169 markers, layout 2"]


@pytest.mark.parametrize(("column", "metrics"), [("rmse_deg", "clean"), ("rmse_jitter_deg", "jittered")])
def test_depth_panels_follow_each_dome_through_its_depths(column, metrics):
    panels = cut_depth_panels(evaluate_grid(PAPER[::-1]), column)
    assert [panel.title for panel in panels] == ["7 markers", "37 markers", "91 markers", "169 markers"]
    assert panels[3].places == (2.4, 8.0)
    curve = panels[3].values[panels[3].domes_mm.index((30.0, 4.0))]
    errors = getattr(make_design(30.0, 4.0, 169), metrics)
    assert curve.tolist() == [depth.pooled.rmse for depth in errors.by_depth]


def test_depth_panels_are_empty_where_the_chain_broke():
    broken = make_design(thickness=3.0, failure="stopped")
    panel = cut_depth_panels(evaluate_grid([broken, make_design()]))[0]
    assert panel.domes_mm == ((20.0, 2.0), (20.0, 3.0))
    assert np.isnan(panel.values).tolist() == [[False, False], [True, True]]
    assert cut_depth_panels(evaluate_grid([broken]))[0].values.shape == (1, 0)


def test_a_grid_that_cannot_be_finished_leaves_the_older_one_as_it_was(tmp_path, monkeypatch):
    write_grid(tmp_path, evaluate_grid([make_design()]))
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(import_module("palpate.study.draw_grid"), "draw_travel", fail)
    with refused("disk-unwritable", "No space left"):
        write_grid(tmp_path, evaluate_grid(FIRST))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_pictures_of_a_single_design_and_of_nothing_but_failures_are_drawn(tmp_path):
    write_grid(tmp_path / "one", evaluate_grid([make_design()]))
    write_grid(tmp_path / "none", evaluate_grid([make_design(failure="stopped")]))
    assert (tmp_path / "one" / "marker_travel.png").exists()
    assert (tmp_path / "none" / "heat_map_rmse.png").exists()


def test_a_folder_without_a_grid_is_reported(tmp_path):
    with refused("grid-missing", "grid.json"):
        read_grid(tmp_path)


def test_a_grid_of_an_older_palpate_says_to_run_the_study_again(tmp_path):
    (tmp_path / "grid.json").write_text('{"format": "palpate specification grid", "version": 1, "rows": []}')
    with refused("grid-older"):
        read_grid(tmp_path)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "other", "version": 1}'])
def test_a_broken_grid_is_reported(tmp_path, text):
    (tmp_path / "grid.json").write_text(text)
    with refused("grid-unreadable"):
        read_grid(tmp_path)


def test_a_folder_that_cannot_be_written_is_reported(tmp_path):
    (tmp_path / "file").write_text("")
    with refused("file-unwritable"):
        write_grid(tmp_path / "file", evaluate_grid(FIRST))


def test_a_row_says_what_its_intervals_are_worth():
    row, broken = evaluate_grid([make_design(), make_design(failure="it broke")]).designs
    assert (row["interval_level"], row["interval_coverage"], row["interval_coverage_depth"]) == (0.9, 0.905, 0.91)
    assert (row["interval_half_width_deg"], row["interval_half_width_mm"]) == (0.8, 0.1)
    assert (row["interval_presses"], row["flagged_ood"]) == (120, 0.011)
    assert broken["interval_coverage"] is None


def test_a_row_says_how_the_dome_deforms():
    (row,) = evaluate_grid([make_design()]).designs
    assert (row["peak_stress_straight_mpa"], row["peak_stress_mpa"]) == (0.04, 0.05)
    assert (row["displacement_max_straight_mm"], row["displacement_mean_straight_mm"]) == (8.0, 3.1)
    assert (row["displacement_max_mm"], row["apex_gap_mm"]) == (9.0, 1.5)


@pytest.mark.parametrize("path", sorted(PUBLISHED.glob("*/grid.json")), ids=lambda path: path.parent.name)
def test_published_grids_have_the_present_columns(path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", FutureWarning)
        grid = read_grid(path.parent)
    header = (path.parent / "grid.csv").read_text("utf-8").partition("\n")[0].split(",")
    assert set(header) <= {"name", *grid.columns}
