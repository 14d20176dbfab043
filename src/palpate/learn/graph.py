"""ONNX graphs from their textual form and arrays: a file holds numbers and no program."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import load_extra

if TYPE_CHECKING:
    from onnx import ModelProto

Arrays = Mapping[str, NDArray[Any]]


def build_model(signature: str, body: str, arrays: Arrays, ir_version: int = 8) -> ModelProto:
    """Model of a graph; opset 17 is old enough for runtimes since 2022.

    Parameters
    ----------
    signature, body
        ``name (inputs) => (outputs)`` and the nodes in order, in the textual syntax of ONNX.
    arrays
        Constants by name; those that no node reads are left out.
    ir_version
        Version of the file format.

    Raises
    ------
    MissingExtraError
        If onnx is not installed.
    """
    load_extra("onnx", "predict")
    from onnx import numpy_helper, parser

    model = parser.parse_model(f'<ir_version: {ir_version}, opset_import: ["" : 17]> {signature} {{ {body} }}')
    used = {name for node in model.graph.node for name in node.input}
    for name, values in arrays.items():
        if name in used:
            model.graph.initializer.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
    return model


def open_session(content: bytes) -> Any:
    """Session of onnxruntime on one core.

    Raises
    ------
    MissingExtraError
        If onnxruntime is not installed.
    """
    onnxruntime = load_extra("onnxruntime", "predict")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4  # errors are reported once, by palpate
    nowhere = str(Path(__file__) / "nowhere")  # else the runtime reads weights from any file that the model names
    options.add_session_config_entry("session.model_external_initializers_file_folder_path", nowhere)
    return onnxruntime.InferenceSession(content, options, ["CPUExecutionProvider"], enable_fallback=0)


def image_graph(arrays: Arrays) -> bytes:
    """Serialised graph of a convolutional network that reads ``picture`` (n, 1, h, w), 0 to 1.

    Convolutions ``kernel_i``, ``shift_i`` with ReLU, each of which halves the image (the first by its stride, others
    by the mean, in old files the maximum, of four), then two dense layers.
    """
    pool = "AveragePool" if "averages" in arrays else "MaxPool"
    body = """
        above = Sub (picture, level)
        scaled = Div (above, spread)"""  # padding is zero after this, as in the training
    last = "scaled"
    for number in range(sum(name.startswith("kernel_") for name in arrays)):
        pad, stride = arrays[f"kernel_{number}"].shape[-1] // 2, 2 if number == 0 else 1
        options = f"pads = [{pad}, {pad}, {pad}, {pad}], strides = [{stride}, {stride}]"
        body += f"""
        c{number} = Conv <{options}> ({last}, kernel_{number}, shift_{number})
        r{number} = Relu (c{number})"""
        last = f"r{number}"
        if number > 0:
            body += f"\np{number} = {pool} <kernel_shape = [2, 2], strides = [2, 2]> (r{number})"
            last = f"p{number}"
    body += f"""
        flat = Flatten ({last})
        d0 = Gemm <transB = 1> (flat, dense_0, add_0)
        e0 = Relu (d0)
        pose = Gemm <transB = 1> (e0, dense_1, add_1)"""
    signature = f"picture (float[image,1,height,width] picture) => (float[image,{len(arrays['add_1'])}] pose)"
    single = {name: np.asarray(values, np.float32) for name, values in arrays.items()}
    return bytes(build_model(signature, body, single, ir_version=9).SerializeToString())
