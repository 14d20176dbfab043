"""A model file must hold its weights: both readers refuse one that names another file."""

from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest

from errors import refused
from palpate.learn import open_predictor, read_estimator
from palpate.learn.io import FORMAT, FORMAT_VERSION, INPUT


def write_model(path: Path, location: str) -> None:
    """A model of our format that adds weights from another file to its input."""
    weights = onnx.TensorProto(name="weights", data_type=onnx.TensorProto.DOUBLE, dims=[600])
    weights.data_location = onnx.TensorProto.EXTERNAL
    for key, value in {"location": location, "offset": "0", "length": "4800"}.items():
        weights.external_data.add(key=key, value=value)
    form = [onnx.helper.make_tensor_value_info(name, onnx.TensorProto.DOUBLE, [1, 300, 2]) for name in (INPUT, "y")]
    shape = onnx.numpy_helper.from_array(np.array([1, 300, 2]), "shape")
    nodes = [
        onnx.helper.make_node("Reshape", ["weights", "shape"], ["shaped"]),
        onnx.helper.make_node("Add", [INPUT, "shaped"], ["y"]),
    ]
    graph = onnx.helper.make_graph(nodes, "g", form[:1], form[1:], [weights, shape])
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 17)], ir_version=8)
    onnx.helper.set_model_props(model, {"format": FORMAT, "format_version": FORMAT_VERSION})
    path.write_bytes(model.SerializeToString())


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "secret.bin").write_bytes(np.arange(600.0).tobytes())
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "model.onnx"
    write_model(path, "secret.bin")
    session = onnxruntime.InferenceSession(path.read_bytes(), providers=["CPUExecutionProvider"])
    read = session.run(None, {INPUT: np.zeros((1, 300, 2))})[0]
    assert read.max() == 599, "the runtime by itself reads the file"
    return path


def test_the_predictor_reads_no_weights_from_another_file(model: Path) -> None:
    with refused("model-unreadable"):
        open_predictor(model)


@pytest.mark.parametrize("location", ["../secret.bin", "/etc/passwd", "model.onnx/../secret.bin"])
def test_the_predictor_follows_no_path_out_of_its_folder(model: Path, location: str) -> None:
    write_model(model, location)
    with refused("model-unreadable"):
        open_predictor(model)


def test_the_estimator_is_not_read_from_another_file(model: Path) -> None:
    with refused("model-unreadable"):
        read_estimator(model)
