"""The front of a search as data for a chart, and folders that nothing is shown of."""

import pytest

from errors import refused
from palpate.optimise import read_search
from palpate.viewer import ServeSpec, serve
from palpate.viewer.charts import FIRST, LIGHT
from palpate.viewer.front_chart import COLUMNS, design_words, front_chart
from small_search import write_search

pytest.importorskip("optuna")
pytest.importorskip("torch")


@pytest.mark.parametrize("column", COLUMNS.values())
def test_every_design_is_one_point_and_the_winner_stands_out(tmp_path, column):
    write_search(tmp_path, finished=True)
    search = read_search(tmp_path)
    chosen = search.front + 2
    chart = front_chart(search, column, chosen, LIGHT)
    series = {part["name"]: part["data"] for part in chart["series"]}
    assert sorted(dot["value"][2] for dots in series.values() for dot in dots) == list(range(len(search.rows)))
    assert [dot["value"][2] for dot in series["winner"]] == [search.winner]
    assert len(series["tried"]) == 8
    for dots in series.values():
        for x, y, number in (dot["value"] for dot in dots):
            assert (x, y) == (search.rows[number][column], search.rows[number]["p95_deg"])
    marked = [dot["value"][2] for dots in series.values() for dot in dots if "itemStyle" in dot]
    assert marked == [chosen]
    assert series["tried"][2]["itemStyle"]["borderColor"] == FIRST


def test_a_design_is_named_by_what_it_is(tmp_path):
    write_search(tmp_path, finished=False)
    search = read_search(tmp_path)
    words = [design_words(search, number).partition(": ")[2] for number in range(len(search.rows))]
    assert words[search.winner] == "winner"
    assert words.count("front") == search.front - 1
    meets = [row["feasible"] for row in search.rows[search.front :]]
    assert [word == "tried" for word in words[search.front :]] == meets
    assert False in meets, "one breaks a limit"


def test_a_folder_with_neither_a_grid_nor_a_search_is_refused_in_a_sentence(tmp_path):
    with refused("results-missing"):
        serve(tmp_path, ServeSpec(), pytest.fail)
