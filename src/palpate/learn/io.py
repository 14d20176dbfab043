"""Estimators as ONNX: any runtime predicts with the file, and opening it runs nothing from it.

The graph reads pixels and gives poses in units:

    markers_px (n, m, 2) double → (· − rest) / scale → float → layers → · sd + mean → pose (n, 3) float

A calibrated estimator also gives half_width (n, 3) and out_of_distribution (n,), see `interval_graph`; forces are
added by `force_graph`, and reading a file as an estimator leaves them out.

The difference to the rest image is taken in double precision and the first bias moved to match, so that single
precision after it costs less than 1e-5 degrees. All data other than weights are in the model's metadata as text.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError, load_extra
from palpate.datasets import Normalisation
from palpate.design import PoseSpace
from palpate.learn.estimator import Estimator
from palpate.learn.graph import build_model
from palpate.learn.interval_graph import (
    HALF_WIDTH,
    INTERVAL_NODES,
    MEMBERS,
    OUT_OF_DISTRIBUTION,
    POSE,
    describe_interval,
    interval_arrays,
    read_interval,
)

if TYPE_CHECKING:
    from onnx import ModelProto


FORMAT, FORMAT_VERSION = "palpate estimator", "2"
INPUT = "markers_px"
"""Name of the graph's input."""
_PLAIN = ("activation", "seed", "training_images", "validation_images", "version")
"""Fields of `Estimator` that the metadata contain as they are."""
AGAIN = "Train the estimator again: `palpate run`."


def write_estimator(path: Path, estimator: Estimator) -> None:
    """Write `estimator` to the ONNX file `path`, replacing it.

    Raises
    ------
    MissingExtraError
        If onnx is not installed.
    """
    load_extra("onnx", "predict")
    from onnx import helper

    markers, count = len(estimator.rest_px), len(estimator.space.components)
    body, arrays = network_graph(estimator)
    outputs = f"float[image,{count}] {POSE}, float[{estimator.members},image,{count}] {MEMBERS}"
    if estimator.interval is not None:
        body, arrays = body + INTERVAL_NODES, arrays | interval_arrays(estimator.interval)
        outputs += f", float[image,{count}] {HALF_WIDTH}, bool[image] {OUT_OF_DISTRIBUTION}"
    model = build_model(f"estimator (double[image,{markers},2] {INPUT}) => ({outputs})", body, arrays)
    model.producer_name, model.producer_version = "palpate", estimator.version
    model.doc_string = f"Pose of the {_pose_text(estimator.space)} from marker positions in pixels."
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
    onnx = load_extra("onnx", "predict")
    from google.protobuf.message import DecodeError

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
    """Return the metadata of a model; reject a model of another format."""
    if metadata.get("format") != FORMAT or metadata.get("format_version") != FORMAT_VERSION:
        raise PalpateError(f"{path} is not an estimator of format {FORMAT_VERSION}.", AGAIN, code="model-version")
    return metadata


def network_graph(estimator: Estimator, prefix: str = "", pose: str = POSE) -> tuple[str, dict[str, NDArray[Any]]]:
    """Nodes of a network up to the mean `pose` of its members, and arrays; `prefix` begins other names."""
    p = prefix
    arrays: dict[str, NDArray[Any]] = {
        f"{p}rest_px": estimator.rest_px,
        f"{p}scale_px": np.array(estimator.normalisation.scale_px),
        f"{p}flat": np.array([-1, 2 * len(estimator.rest_px)]),
        f"{p}output_sd": estimator.output_sd.astype(np.float32),
        f"{p}output_mean": estimator.output_mean.astype(np.float32),
    }
    body = f"""
        {p}moved_px = Sub ({INPUT}, {p}rest_px)
        {p}moved = Div ({p}moved_px, {p}scale_px)
        {p}single = Cast <to = 1> ({p}moved)
        {p}hidden_0 = Reshape ({p}single, {p}flat)"""
    last = len(estimator.weights) - 1
    for n, (weight, bias) in enumerate(zip(estimator.weights, estimator.biases, strict=True)):
        single = weight.astype(np.float32)
        shift = _rest_input(estimator.normalisation, estimator.rest_px) @ single if n == 0 else 0.0
        arrays[f"{p}weight_{n}"] = single
        arrays[f"{p}bias_{n}"] = (bias + shift).astype(np.float32)[:, None, :]
        body += f"""
        {p}product_{n} = MatMul ({p}hidden_{n}, {p}weight_{n})
        {p}sum_{n} = Add ({p}product_{n}, {p}bias_{n})"""
        if n < last and estimator.activation == "relu":
            body += f"\n{p}hidden_{n + 1} = Relu ({p}sum_{n})"
        elif n < last:
            body += f"\n{p}gate_{n} = Sigmoid ({p}sum_{n})\n{p}hidden_{n + 1} = Mul ({p}sum_{n}, {p}gate_{n})"
    body += f"""
        {p}scaled = Mul ({p}sum_{last}, {p}output_sd)
        {p}{MEMBERS} = Add ({p}scaled, {p}output_mean)
        {pose} = ReduceMean <axes = [0], keepdims = 0> ({p}{MEMBERS})"""
    return body, arrays


def _rest_input(normalisation: Normalisation, rest_px: FloatArray) -> FloatArray:
    """Input of the first layer at rest, (2m,)."""
    return normalisation.apply(rest_px).reshape(-1)


def _metadata(estimator: Estimator) -> dict[str, str]:
    content: dict[str, Any] = {
        "inputs": ["u_px", "v_px"],
        "outputs": list(estimator.space.names),
        "units": {INPUT: "px", **{item.name: item.unit for item in estimator.space.components}},
        "marker_order_px": estimator.rest_px.tolist(),
        **{name: getattr(estimator, name) for name in _PLAIN},
        "offset_px": estimator.normalisation.offset_px,
        "scale_px": estimator.normalisation.scale_px,
        "made_by": dict(estimator.made_by),
        "history": estimator.history,
        "repeat_rmse_deg": estimator.repeat_rmse_deg,
    }
    if estimator.interval is not None:
        content["interval"] = describe_interval(estimator.interval)
    words = {name: json.dumps(value) for name, value in content.items()}
    return {"format": FORMAT, "format_version": FORMAT_VERSION, **words}


def _read(model: ModelProto, metadata: dict[str, str]) -> Estimator:
    from onnx import numpy_helper

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
        output_mean=arrays["output_mean"].astype(float),
        output_sd=arrays["output_sd"].astype(float),
        rest_px=arrays["rest_px"],
        made_by=facts["made_by"],
        history=tuple(tuple(errors) for errors in facts["history"]),
        repeat_rmse_deg=tuple(facts["repeat_rmse_deg"]),
        interval=read_interval(facts["interval"], arrays) if "interval" in facts else None,
        **{name: facts[name] for name in _PLAIN},
        space=PoseSpace.from_names(facts["outputs"]),
    )


def _pose_text(space: PoseSpace) -> str:
    parts = ", ".join(f"{item.axis} {item.unit}" for item in space.components)
    return f"{'wall' if space.is_tilt else 'obstacle'} ({parts})"
