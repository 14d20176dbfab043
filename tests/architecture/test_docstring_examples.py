"""Examples in docstrings run, and the verbs that are called most have one."""

import doctest
import importlib
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src"
FILES = sorted(path for path in SOURCE.rglob("*.py") if ">>> " in path.read_text(encoding="utf-8"))
VERBS = {
    "camera": ["build_camera", "flat_marker_outlines", "render", "tangent_pair"],
    "core": ["child_seed", "flag_name", "generator", "parameters", "provenance"],
    "datasets": ["draw_jitter", "generate_dataset", "sample_poses", "split_presses"],
    "design": [
        "build_contact_module",
        "build_skin",
        "check_design",
        "place_markers",
        "place_orientation_mark",
        "ring_diameters",
        "rotation_vector",
        "turn_about_axis",
        "wall_normal",
    ],
    "learn": ["fit_ridge", "measure_errors"],
    "sensor": ["find_depth_zero", "score_readings"],
    "study": ["design_label", "grid_column", "read_study"],
}


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_examples_of_docstrings_give_what_they_show(path: Path) -> None:
    module = importlib.import_module(
        ".".join(path.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__")
    )
    assert doctest.testmod(module).failed == 0


@pytest.mark.parametrize("room", VERBS)
def test_the_verbs_that_are_called_most_have_an_example(room: str) -> None:
    door = importlib.import_module(f"palpate.{room}")
    assert [name for name in VERBS[room] if ">>> " not in (getattr(door, name).__doc__ or "")] == []
