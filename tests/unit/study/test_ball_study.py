"""Studies of obstacles without a tilt: their grid at every door, in mm, and what only walls have."""

import json
from pathlib import Path

import pytest

from errors import check_refusal, refused
from needs import needs
from palpate.cli import main
from palpate.study import Study, compare_grids, design_spec, plan_twin, read_grid
from palpate.study.accuracy_task import plan_prediction
from palpate.viewer.curves import error_curves
from presses import stored_folder
from results import leave_out_pictures

BALL = {"kind": "ball", "radius": 8, "depth": 2, "depth_step": 0.25, "contact": "frictionless"}
EDGE = {"kind": "edge", "depth": 2.4, "depth_step": 0.4, "contact": "frictionless"}


def study_of(obstacle: dict[str, object], **more: object) -> dict[str, object]:
    return {
        "name": "offsets",
        "designs": {"heights": [20], "thicknesses": [2], "markers": [19]},
        "obstacle": obstacle,
        "offsets_mm": [0, 2, 4],
        "mesh": {"cells": 5},
        "dataset": {"n_presses": 40},
        "learning": {"preset": "quick"},
        **more,
    }


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    return int(left.value.code or 0)


def results_of(obstacle: dict[str, object]) -> Path:
    needs("torch")
    study = json.dumps(study_of(obstacle))

    def make(folder: Path) -> None:
        (folder / "study.yaml").write_text(study)
        with pytest.MonkeyPatch.context() as changes:
            leave_out_pictures(changes)
            assert run("run", folder / "study.yaml", "--out", folder / "results", "--workers", 1, "--json") == 0

    return stored_folder("study", [study], make) / "results"


@pytest.fixture(scope="module")
def ball() -> Path:
    return results_of(BALL)


def test_the_row_of_a_ball_has_errors_and_bounds_in_mm(ball: Path) -> None:
    (row,) = read_grid(ball).designs
    assert 0 < row["rmse_mm"] < row["max_error_mm"] < 10
    assert row["bound_mm"] > 0
    assert not {"rmse_deg", "bound_deg", "max_error_deg"} & set(row)
    assert design_spec(row)["offsets_mm"] == [0, 2, 4]
    assert [press["offset_mm"] for press in read_grid(ball).presses] == [0, 2, 4]


def test_an_edge_has_a_row_without_a_bound() -> None:
    """Near the axis the place of a line does not determine its direction."""
    (row,) = read_grid(results_of(EDGE)).designs
    assert not row["failure"]
    assert 0 < row["rmse_mm"] < 10
    assert row["bound_mm"] is None


@pytest.mark.parametrize(
    "words", ["grid show {}", "grid compare {} {}", "limit {}", "grid plot {} --kind depth -o {out}", "claims {}"]
)
def test_verbs_that_read_a_grid_read_one_of_offsets(words: str, ball: Path, tmp_path: Path, capsys) -> None:
    assert run(*words.format(ball, ball, out=tmp_path).split()) == 0, capsys.readouterr().err


def test_the_model_of_the_least_error_is_taken_without_a_column_being_named(ball: Path, tmp_path: Path) -> None:
    assert run("study", "model", ball, "-o", tmp_path / "model.onnx") == 0
    assert (tmp_path / "model.onnx").stat().st_size > 0


def test_bounds_are_listed_in_mm(ball: Path, capsys) -> None:
    assert run("design", "bound", ball, "--json") == 0
    (design,) = json.loads(capsys.readouterr().out)["designs"]
    assert design["bound_mm"] == read_grid(ball).designs[0]["bound_mm"]
    assert {"least_squares_mm", "pitman_mm", "floor_mm"} <= set(design["by_depth"][0])


def test_the_viewer_draws_its_errors_by_depth(ball: Path) -> None:
    from palpate.viewer.results import read_design, read_results

    results = read_results(ball)
    curves = error_curves(results.grid, [read_design(results, 0)])
    assert [curve.name for curve in curves] == ["network", "least-squares bound"]
    assert all(curve.points for curve in curves)


def test_a_grid_of_before_the_rename_differs_in_nothing_by_its_key(ball: Path) -> None:
    new = read_grid(ball)
    spec = json.loads(new.designs[0]["spec"])
    spec["wall"] = spec.pop("obstacle")
    old = new.select(new.designs)
    old = type(old)(({**new.designs[0], "spec": json.dumps(spec)},), old.by_depth, old.by_tilt, old.presses)
    assert compare_grids(old, new).differences == ()


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"built": {}}, "built"),
        ({"forces": True}, "forces"),
        ({"dataset": {"max_tilt_deg": 4}}, "dataset.max_tilt_deg"),
    ],
)
def test_what_only_walls_have_is_refused(change: dict[str, object], name: str) -> None:
    with refused("key-needs-wall", name, "ball 8 mm"):
        Study.model_validate(study_of(BALL, **change))


def test_a_twin_of_a_ball_is_refused_before_a_press(tmp_path: Path, capsys) -> None:
    study = Study.model_validate(study_of(BALL))
    with refused("twin-needs-wall", "ball 8 mm"):
        plan_twin(study, study.designs.skins()[0])
    (tmp_path / "study.yaml").write_text(json.dumps(study_of(BALL)))
    assert run("calibration", "predict", tmp_path / "study.yaml", "--out", tmp_path / "twins") == 2
    check_refusal(capsys.readouterr().err, "twin-needs-wall", "ball 8 mm")


def test_a_twin_of_a_curved_wall_is_refused_and_its_study_has_no_prediction() -> None:
    """A twin has no curvature of its own: it would read images of the curved wall as those of a flat one."""
    skins = {"heights": ["20 mm"], "thicknesses": ["2 mm"], "markers": [7]}
    given = {"name": "walls", "designs": skins, "tilts_deg": [0, 4, 8]}
    curved, flat = (Study.model_validate({**given, "obstacle": wall}) for wall in ({"curvature": 5}, {}))
    skin = flat.designs.skins()[0]
    with refused("twin-needs-wall", "5"):
        plan_twin(curved, skin)
    assert plan_prediction(curved, skin) is None
    assert plan_twin(flat, skin).presses
