"""Links and charts: data in, data out."""

import json
from dataclasses import replace

import numpy as np
import pytest
from made_up_presses import MESH, depths, made_up_press, rows

from palpate.design import Design, MarkerSpec, place_markers
from palpate.study import SpecificationGrid
from palpate.viewer.charts import LIGHT, Selection, heat_chart, line_chart, pareto_front, scatter_chart
from palpate.viewer.curves import error_curves, force_curves
from palpate.viewer.labels import column_label, find_column, jitter_words
from palpate.viewer.link import (
    ColourQuantity,
    View,
    first_view,
    numeric_columns,
    read_link,
    selected_rows,
    write_link,
)
from palpate.viewer.pressed_skin import build_pressed_skin
from palpate.viewer.results import GridDesign

GRID = SpecificationGrid(rows(), depths())


def test_a_link_restores_the_view():
    view = View(
        design=1,
        other=0,
        metric="travel_mm",
        across="force_n",
        up="rmse_deg",
        where="markers > 7",
        depth=3.25,
        tilt=4.5,
        azimuth=210.0,
        cut_at=-3.5,
        colour=ColourQuantity.STRESS,
        cut=False,
        trails=False,
    )
    query = dict(part.split("=") for part in write_link(view, first_view(GRID)).split("&"))
    query["where"] = "markers > 7"
    assert read_link(query, GRID) == (view, ())
    assert write_link(first_view(GRID), first_view(GRID)) == ""
    assert write_link(replace(first_view(GRID), design=0), first_view(GRID)) == "design=0"


def test_the_first_view_is_the_best_design():
    assert first_view(GRID).design == 1
    assert first_view(GRID).metric == "rmse_jitter_deg"


@pytest.mark.parametrize(
    "query",
    [
        {"design": "9"},
        {"design": "-1"},
        {"design": "x"},
        {"other": "99"},
        {"metric": "spec"},
        {"metric": "nothing"},
        {"where": "__import__('os')"},
        {"depth": "nan"},
        {"tilt": "1e9"},
        {"azimuth": "inf"},
        {"cut_at": "x"},
        {"colour": "red"},
        {"cut": "yes"},
    ],
)
def test_what_a_link_gets_wrong_is_left_out_and_reported(query):
    view, complaints = read_link(query, GRID)
    assert view == first_view(GRID)
    assert len(complaints) == 1


def test_columns_of_text_are_no_metric():
    assert "spec" not in numeric_columns(GRID)
    assert "rmse_deg" in numeric_columns(GRID)


def test_an_empty_question_keeps_every_design():
    assert selected_rows(GRID, "  ") == {0, 1, 2}
    assert selected_rows(GRID, "rmse_deg < 0.3") == {1}


def test_every_design_has_a_cell_that_names_its_row():
    options = heat_chart(GRID, "rmse_deg", Selection({0}, 1, 0), LIGHT)
    cells = [cell for series in options["series"] for cell in series["data"]]
    assert [cell["value"][3] for cell in cells] == [0, 1, 2]
    assert [cell["visualMap"] for cell in cells] == [True, False, False]
    assert [series["name"] for series in options["series"]] == ["7 markers", "19 markers", "37 markers"]


def test_figures_of_cells_have_two_digits():
    figures = [0.0951, 0.1, 2.0, 20.04, 99.6, 314.2]
    table = SpecificationGrid(
        [row | {"rmse_deg": value} for row, value in zip([rows()[0]] * 6, figures, strict=True)], []
    )
    options = heat_chart(table, "rmse_deg", Selection({0}, 0, 0), LIGHT)
    shown = [cell["label"]["formatter"] for series in options["series"] for cell in series["data"]]
    assert shown == ["0.095", "0.10", "2.0", "20", "100", "314"]


def test_the_front_is_what_nothing_beats():
    points = [(0, 1.0, 5.0), (1, 2.0, 2.0), (2, 3.0, 3.0), (3, 4.0, 1.0), (4, 1.0, 6.0)]
    assert pareto_front(points) == [0, 1, 3]
    assert pareto_front([]) == []


def test_designs_without_a_figure_are_not_in_the_scatter():
    options = scatter_chart(GRID, ("force_n", "rmse_deg"), Selection({0, 1, 2}, 0), LIGHT)
    assert [dot["value"][2] for dot in options["series"][1]["data"]] == [0, 1]


def test_curves_change_their_dash_with_the_branch():
    presses = [made_up_press(0.0, inverted_from=2.0)]
    layout = place_markers(MESH.skin, MarkerSpec(count=7))
    design = GridDesign(0, rows()[0], Design.of_skin(MESH.skin, layout), ())
    curves, marks = force_curves([(design, build_pressed_skin(presses).at(0.0))])
    assert [(curve.name, curve.dashed) for curve in curves] == [("flat", False), ("inverted", True)]
    assert marks[0].points[0][0] == pytest.approx(3.2)
    errors = error_curves(GRID, [design])
    assert [curve.name for curve in errors] == ["network", "least-squares bound"]
    assert errors[1].points == [(0.8, 1.0), (1.6, 0.5)]
    options = line_chart(curves, ("depth (mm)", "force (N)"), LIGHT, marks)
    assert options["series"][0]["data"][1] == [pytest.approx(0.8), pytest.approx(0.08)]


def test_words_of_columns_have_units():
    assert column_label("travel_mm") == "marker travel (mm)"
    assert column_label("rmse_spread_deg") == "RMSE spread (°)"
    assert column_label("bound_deg") == "least-squares bound (°)"
    assert column_label("p95_deg") == "95th percentile (°)"
    assert find_column("travel_mm").text(None) == "–"
    assert find_column("travel_mm").text(np.pi) == "3.142"


def test_the_jitter_is_the_studys():
    studies = [{"spec": json.dumps({"dataset": {"jitter_px": jitter}})} for jitter in (0.5, 2.0, 2.0)]
    assert jitter_words(SpecificationGrid(tuple(studies[1:]))) == "2 px jitter"
    assert jitter_words(SpecificationGrid(tuple(studies))) == "0.5 or 2 px jitter"
    assert jitter_words(GRID) == "jitter"
