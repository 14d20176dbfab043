"""A convolutional network as an ONNX graph, built from its arrays alone: a model file holds numbers and no program.

Convolutions ``kernel_i``, ``shift_i`` with ReLU, each of which halves the picture (the first by its stride, others by
the greatest of four), then two dense layers.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import MissingExtraError

_OPSET, _IR = 17, 9


def graph_of(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Serialised graph of a network that reads ``picture`` (n, 1, h, w), 0 to 1.

    Raises
    ------
    MissingExtraError
        If onnx is not installed.
    """
    try:
        from onnx import TensorProto, helper, numpy_helper
    except ImportError as error:
        raise MissingExtraError("onnx", "predict") from error
    layers = sum(name.startswith("kernel_") for name in arrays)
    constants = {name: np.asarray(values, np.float32) for name, values in arrays.items()}
    nodes = [
        helper.make_node("Sub", ["picture", "level"], ["above"]),  # padding is zero after this, as in the training
        helper.make_node("Div", ["above", "spread"], ["scaled"]),
    ]
    now = "scaled"
    for number in range(layers):
        size = arrays[f"kernel_{number}"].shape[-1]
        nodes.append(
            helper.make_node(
                "Conv",
                [now, f"kernel_{number}", f"shift_{number}"],
                [f"c{number}"],
                pads=[size // 2] * 4,
                strides=[2 if number == 0 else 1] * 2,
            )
        )
        nodes.append(helper.make_node("Relu", [f"c{number}"], [f"r{number}"]))
        now = f"r{number}"
        if number > 0:
            kind = "AveragePool" if "averages" in arrays else "MaxPool"
            nodes.append(helper.make_node(kind, [now], [f"p{number}"], kernel_shape=[2, 2], strides=[2, 2]))
            now = f"p{number}"
    nodes.append(helper.make_node("Flatten", [now], ["flat"]))
    nodes.append(helper.make_node("Gemm", ["flat", "dense_0", "add_0"], ["d0"], transB=1))
    nodes.append(helper.make_node("Relu", ["d0"], ["e0"]))
    nodes.append(helper.make_node("Gemm", ["e0", "dense_1", "add_1"], ["pose"], transB=1))
    used = {name for node in nodes for name in node.input}
    graph = helper.make_graph(
        nodes,
        "picture",
        [helper.make_tensor_value_info("picture", TensorProto.FLOAT, ["image", 1, "height", "width"])],
        [helper.make_tensor_value_info("pose", TensorProto.FLOAT, ["image", len(arrays["add_1"])])],
        [
            numpy_helper.from_array(np.ascontiguousarray(values), name)
            for name, values in constants.items()
            if name in used
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=_IR)
    return bytes(model.SerializeToString())
