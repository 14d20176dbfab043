"""Bounds of a finished study by the command line: its rows, its units, and a grid that has none."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from errors import check_refusal
from palpate.cli import main
from palpate.study import evaluate_grid, write_grid
from results import LIMITS, leave_out_pictures, make_design


def asked(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as left:
        main(list(words))
    said = capsys.readouterr()
    return int(left.value.code or 0), said.out, said.err


def test_bounds_of_a_finished_study_are_those_of_its_grid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    leave_out_pictures(monkeypatch)
    designs = [make_design(), make_design(thickness=3.0)]
    write_grid(tmp_path, evaluate_grid(designs))
    code, out, _ = asked(capsys, "limit", str(tmp_path), "--json")
    found = json.loads(out)["designs"]
    assert code == 0
    assert [row["thickness_mm"] for row in found] == [2.0, 3.0]
    for row in found:
        assert [part["depth_mm"] for part in row["by_depth"]] == [limit.depth_mm for limit in LIMITS]
        assert [part["least_squares_deg"] for part in row["by_depth"]] == [one.least_squares_deg for one in LIMITS]
        assert [part["pitman_deg"] for part in row["by_depth"]] == [limit.pitman_deg for limit in LIMITS]
        assert LIMITS[1].least_squares_deg < row["bound_deg"] < LIMITS[0].least_squares_deg


def test_a_grid_without_bounds_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    leave_out_pictures(monkeypatch)
    write_grid(tmp_path, evaluate_grid([replace(make_design(), bounds=())]))
    code, _, err = asked(capsys, "limit", str(tmp_path))
    assert code == 2
    check_refusal(err, "grid-no-limits", tmp_path.name)
