"""The model of a design, taken out of a store."""

from dataclasses import replace
from pathlib import Path

from errors import refused
from needs import needs
from palpate.study import SpecificationGrid, copy_model

ROW = {"height_mm": 20.0, "thickness_mm": 2.0, "markers": 37, "estimator_key": "ff00"}
GRID = SpecificationGrid((ROW,))


def test_copy_model_says_why_there_is_none(tmp_path: Path) -> None:
    with refused("grid-selection-empty"):
        copy_model(tmp_path, replace(GRID, designs=()), tmp_path / "a.onnx")
    with refused("model-missing", "H20 T2", "37"):
        copy_model(tmp_path, replace(GRID, designs=({**ROW, "estimator_key": None},)), tmp_path / "a.onnx")
    with refused("artefact-not-stored"):
        copy_model(tmp_path, GRID, tmp_path / "a.onnx")


def test_a_file_that_is_no_model_is_not_copied(tmp_path: Path) -> None:
    needs("onnxruntime")
    path = tmp_path / "store" / "estimator" / "ff" / "ff00.onnx"
    path.parent.mkdir(parents=True)
    path.write_bytes(b"no model")
    with refused("model-unreadable"):
        copy_model(tmp_path, GRID, tmp_path / "a.onnx")
    assert not (tmp_path / "a.onnx").exists()
