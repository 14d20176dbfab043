"""Estimators as ONNX: any runtime predicts with the file, and opening it runs nothing from it.

The graph reads pixels and gives poses in units:

    markers_px (n, m, 2) double → (· − rest) / scale → float → layers → · sd + mean → pose (n, 3) float

A calibrated estimator also gives half_width (n, 3) and out_of_distribution (n,), see `interval_graph`; forces are
added by `force_graph`, and reading a file as an estimator leaves them out.

The difference to the rest image is taken in double precision and the first bias moved to match, so that single
precision after it costs less than 1e-5 degrees. Everything that is no weight stands in the model's metadata as text.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, MissingExtraError, PalpateError
from palpate.dataset import Normalisation
from palpate.design import PoseSpace
from palpate.learn.estimator import Estimator
from palpate.learn.interval_graph import (
    HALF_WIDTH,
    MEMBERS,
    OUT_OF_DISTRIBUTION,
    POSE,
    describe_interval,
    interval_nodes,
    read_interval,
)

if TYPE_CHECKING:
    from onnx import ModelProto, NodeProto


FORMAT, FORMAT_VERSION = "palpate estimator", "2"
INPUT = "markers_px"
"""Name of the graph's input."""
OPSET, IR_VERSION = 17, 8
"""Old enough for runtimes since 2022."""
AGAIN = "Train the estimator again: `palpate run`."


def write_estimator(path: Path, estimator: Estimator) -> None:
    """Write `estimator` to the ONNX file `path`, replacing it.

    Raises
    ------
    MissingExtraError
        If onnx is not installed.
    """
    try:
        from onnx import TensorProto, helper
    except ImportError as error:
        raise MissingExtraError("onnx", "predict") from error
    markers, count = len(estimator.rest_px), len(estimator.space.components)
    nodes, constants = graph_of(estimator)
    outputs = [
        helper.make_tensor_value_info(POSE, TensorProto.FLOAT, ["image", count]),
        helper.make_tensor_value_info(MEMBERS, TensorProto.FLOAT, [estimator.members, "image", count]),
    ]
    if estimator.interval is not None:
        more, values = interval_nodes(estimator.interval)
        nodes, constants = nodes + more, constants | values
        outputs.append(helper.make_tensor_value_info(HALF_WIDTH, TensorProto.FLOAT, ["image", count]))
        outputs.append(helper.make_tensor_value_info(OUT_OF_DISTRIBUTION, TensorProto.BOOL, ["image"]))
    graph = helper.make_graph(
        nodes,
        "estimator",
        [helper.make_tensor_value_info(INPUT, TensorProto.DOUBLE, ["image", markers, 2])],
        outputs,
        [tensor_of(name, values) for name, values in constants.items()],
    )
    model = helper.make_model(
        graph,
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
        producer_name="palpate",
        producer_version=estimator.version,
        doc_string=f"Pose of the {_pose_text(estimator.space)} from marker positions in pixels.",
    )
    helper.set_model_props(model, _metadata(estimator))
    path.write_bytes(model.SerializeToString(deterministic=True))


def read_estimator(path: Path) -> Estimator:
    """Read an estimator written by `write_estimator`.

    Raises
    ------
    PalpateError
        If the file is not an estimator, is of another format, or holds something that is not a number.
    MissingExtraError
        If onnx is not installed.
    """
    try:
        import onnx
        from google.protobuf.message import DecodeError
    except ImportError as error:
        raise MissingExtraError("onnx", "predict") from error
    try:
        model = onnx.load_model_from_string(path.read_bytes())
        if any(weights.data_location == onnx.TensorProto.EXTERNAL for weights in model.graph.initializer):
            raise ValueError("its weights lie in another file")
        estimator = _read(model, check_format(path, {item.key: item.value for item in model.metadata_props}))
    except (OSError, DecodeError, LookupError, ValueError, TypeError) as error:
        raise PalpateError(f"{path} is not an estimator: {error}.", AGAIN, code="model-unreadable") from error
    if not all(np.isfinite(part).all() for part in (*estimator.weights, *estimator.biases)):
        raise PalpateError(f"{path} holds a weight that is not a number.", AGAIN, code="model-not-finite")
    return estimator


def check_format(path: Path, metadata: dict[str, str]) -> dict[str, str]:
    """The metadata of a model, after a model that is no estimator of this format was refused."""
    if metadata.get("format") != FORMAT or metadata.get("format_version") != FORMAT_VERSION:
        raise PalpateError(f"{path} is not an estimator of format {FORMAT_VERSION}.", AGAIN, code="model-version")
    return metadata


def graph_of(estimator: Estimator) -> tuple[list[NodeProto], dict[str, NDArray[Any]]]:
    """Nodes of a network in order, from the input to the mean over its members, and the arrays that they read."""
    from onnx import TensorProto, helper

    constants: dict[str, NDArray[Any]] = {
        "rest_px": estimator.rest_px,
        "scale_px": np.array(estimator.normalisation.scale_px),
        "flat": np.array([-1, 2 * len(estimator.rest_px)]),
        "output_sd": estimator.output_sd.astype(np.float32),
        "output_mean": estimator.output_mean.astype(np.float32),
    }
    nodes = [
        helper.make_node("Sub", [INPUT, "rest_px"], ["moved_px"]),
        helper.make_node("Div", ["moved_px", "scale_px"], ["moved"]),
        helper.make_node("Cast", ["moved"], ["single"], to=TensorProto.FLOAT),
        helper.make_node("Reshape", ["single", "flat"], ["hidden_0"]),
    ]
    last = len(estimator.weights) - 1
    for number, (weight, bias) in enumerate(zip(estimator.weights, estimator.biases, strict=True)):
        single = weight.astype(np.float32)
        shift = _rest_input(estimator.normalisation, estimator.rest_px) @ single if number == 0 else 0.0
        constants[f"weight_{number}"] = single
        constants[f"bias_{number}"] = (bias + shift).astype(np.float32)[:, None, :]
        nodes.append(helper.make_node("MatMul", [f"hidden_{number}", f"weight_{number}"], [f"product_{number}"]))
        nodes.append(helper.make_node("Add", [f"product_{number}", f"bias_{number}"], [f"sum_{number}"]))
        if number < last:
            nodes.extend(_activation(estimator.activation, number))
    nodes.append(helper.make_node("Mul", [f"sum_{last}", "output_sd"], ["scaled"]))
    nodes.append(helper.make_node("Add", ["scaled", "output_mean"], [MEMBERS]))
    nodes.append(helper.make_node("ReduceMean", [MEMBERS], [POSE], axes=[0], keepdims=0))
    return nodes, constants


def _activation(name: str, number: int) -> list[NodeProto]:
    from onnx import helper

    values, hidden = f"sum_{number}", f"hidden_{number + 1}"
    if name == "relu":
        return [helper.make_node("Relu", [values], [hidden])]
    gate = helper.make_node("Sigmoid", [values], [f"gate_{number}"])
    return [gate, helper.make_node("Mul", [values, f"gate_{number}"], [hidden])]


def _rest_input(normalisation: Normalisation, rest_px: FloatArray) -> FloatArray:
    """What the first layer reads at rest, (2m,)."""
    return normalisation.apply(rest_px).reshape(-1)


def tensor_of(name: str, values: NDArray[Any]) -> Any:
    """An array of the graph by its name."""
    from onnx import numpy_helper

    return numpy_helper.from_array(np.ascontiguousarray(values), name)


def _metadata(estimator: Estimator) -> dict[str, str]:
    content: dict[str, Any] = {
        "inputs": ["u_px", "v_px"],
        "outputs": list(estimator.space.names),
        "units": {INPUT: "px", **{item.name: item.unit for item in estimator.space.components}},
        "marker_order_px": estimator.rest_px.tolist(),
        "activation": estimator.activation,
        "offset_px": estimator.normalisation.offset_px,
        "scale_px": estimator.normalisation.scale_px,
        "seed": estimator.seed,
        "made_by": dict(estimator.made_by),
        "training_images": estimator.training_images,
        "validation_images": estimator.validation_images,
        "history": estimator.history,
        "repeat_rmse_deg": estimator.repeat_rmse_deg,
        "version": estimator.version,
    }
    if estimator.interval is not None:
        content["interval"] = describe_interval(estimator.interval)
    words = {name: json.dumps(value) for name, value in content.items()}
    return {"format": FORMAT, "format_version": FORMAT_VERSION, **words}


def _read(model: ModelProto, metadata: dict[str, str]) -> Estimator:
    from onnx import TensorProto, numpy_helper

    if any(item.data_location == TensorProto.EXTERNAL for item in model.graph.initializer):
        raise ValueError("its weights lie in another file")
    arrays = {item.name: numpy_helper.to_array(item) for item in model.graph.initializer}
    facts = {name: json.loads(text) for name, text in metadata.items() if not name.startswith("format")}
    layers = range(sum(name.startswith("weight_") for name in arrays))
    weights = tuple(arrays[f"weight_{number}"].astype(float) for number in layers)
    biases = [arrays[f"bias_{number}"].astype(float)[:, 0, :] for number in layers]
    normalisation = Normalisation(tuple(facts["offset_px"]), tuple(facts["scale_px"]))
    biases[0] = biases[0] - _rest_input(normalisation, arrays["rest_px"]) @ weights[0]
    return Estimator(
        normalisation=normalisation,
        weights=weights,
        biases=tuple(biases),
        activation=facts["activation"],
        output_mean=arrays["output_mean"].astype(float),
        output_sd=arrays["output_sd"].astype(float),
        rest_px=arrays["rest_px"],
        seed=facts["seed"],
        made_by=facts["made_by"],
        training_images=facts["training_images"],
        validation_images=facts["validation_images"],
        history=tuple(tuple(errors) for errors in facts["history"]),
        repeat_rmse_deg=tuple(facts["repeat_rmse_deg"]),
        interval=read_interval(facts["interval"], arrays) if "interval" in facts else None,
        version=facts["version"],
        space=PoseSpace.from_names(facts["outputs"]),
    )


def _pose_text(space: PoseSpace) -> str:
    parts = ", ".join(f"{item.axis} {item.unit}" for item in space.components)
    return f"{'wall' if space.is_tilt else 'obstacle'} ({parts})"
