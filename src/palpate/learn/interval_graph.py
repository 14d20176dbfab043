"""The interval as part of the ONNX graph, so that any runtime gives it with the pose.

    half_width (n, 3) float, in the pose's units:  factor · sqrt( var over members + error(depth)² )
    out_of_distribution (n,) bool:                 score of the displacement > threshold

The error by depth is linear between knots, hence a sum of hinges: error(z) = e₀ + Σ cᵢ max(z − zᵢ, 0).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray
from palpate.learn.interval import Interval, TrainedRange

if TYPE_CHECKING:
    from onnx import NodeProto

Arrays = dict[str, NDArray[Any]]

POSE, MEMBERS, HALF_WIDTH, OUT_OF_DISTRIBUTION = "pose", "member_poses", "half_width", "out_of_distribution"
"""Names of the graph's outputs: mean over the members, each member (r, n, 3), half-widths, flags."""
MOVED = "moved_px"
"""Name of the displacement from rest (n, m, 2) in the graph, double."""

_SCALARS = (
    "noise_px",
    "rest_mean_px",
    "rest_sd_px",
    "tilt_deg",
    "min_depth_mm",
    "max_depth_mm",
    "threshold",
    "false_alarm",
)
_VECTORS = ("centre", "directions", "low", "high")


def describe_interval(interval: Interval) -> dict[str, Any]:
    """What stands in the metadata, as JSON data: everything but arrays."""
    trained = {name: getattr(interval.trained, name) for name in _SCALARS}
    return {"level": interval.level, "presses": list(interval.presses), "trained_range": trained}


def read_interval(content: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Interval:
    """The interval from its description and the arrays of the graph."""
    trained: dict[str, Any] = {name: arrays[f"range_{name}"].astype(float) for name in _VECTORS}
    trained |= {name: float(content["trained_range"][name]) for name in _SCALARS}
    depths = arrays["error_depths"].astype(float)
    return Interval(
        level=float(content["level"]),
        factor=arrays["factor"].astype(float),
        depths_mm=depths,
        error=_from_hinges(depths, arrays["error_first"].astype(float), arrays["error_hinges"].astype(float)),
        trained=TrainedRange(**trained),
        presses=tuple(content["presses"]),
    )


def interval_nodes(interval: Interval) -> tuple[list[NodeProto], Arrays]:
    """Nodes after those of the pose, in order, and the arrays that they read."""
    width, width_arrays = _width_nodes(interval)
    score, score_arrays = _score_nodes(interval.trained)
    return width + score + _pose_nodes(len(interval.factor)), width_arrays | score_arrays


def _width_nodes(interval: Interval) -> tuple[list[NodeProto], Arrays]:
    from onnx import helper

    node = helper.make_node
    arrays: Arrays = {
        "depth_axis": np.array([2]),
        "error_depths": _single(interval.depths_mm),
        "error_first": _single(interval.error[0]),
        "error_hinges": _single(_to_hinges(interval.depths_mm, interval.error)),
        "factor": _single(interval.factor),
    }
    nodes = [
        node("Sub", [MEMBERS, POSE], ["apart"]),
        node("Mul", ["apart", "apart"], ["apart_squared"]),
        node("ReduceMean", ["apart_squared"], ["spread_squared"], axes=[0], keepdims=0),
        node("Gather", [POSE, "depth_axis"], ["depth"], axis=1),
        node("Sub", ["depth", "error_depths"], ["beyond"]),
        node("Relu", ["beyond"], ["hinges"]),
        node("MatMul", ["hinges", "error_hinges"], ["error_change"]),
        node("Add", ["error_change", "error_first"], ["error"]),
        node("Mul", ["error", "error"], ["error_squared"]),
        node("Add", ["spread_squared", "error_squared"], ["scale_squared"]),
        node("Sqrt", ["scale_squared"], ["error_scale"]),
        node("Mul", ["error_scale", "factor"], [HALF_WIDTH]),
    ]
    return nodes, arrays


def _score_nodes(trained: TrainedRange) -> tuple[list[NodeProto], Arrays]:
    from onnx import TensorProto, helper

    node = helper.make_node
    arrays: Arrays = {f"range_{name}": _single(getattr(trained, name)) for name in _VECTORS}
    arrays |= {f"range_{name}": _single(np.array(getattr(trained, name))) for name in _SCALARS[:-1]}
    arrays["column"] = np.array([1])
    arrays["range_back"] = _single(np.ascontiguousarray(trained.directions.T))
    nodes = [
        node("Cast", [MOVED], ["moved_single"], to=TensorProto.FLOAT),
        node("Reshape", ["moved_single", "flat"], ["displacement"]),
        node("Sub", ["displacement", "range_centre"], ["centred"]),
        node("MatMul", ["centred", "range_directions"], ["coordinates"]),
        node("Sub", ["range_low", "coordinates"], ["below"]),
        node("Sub", ["coordinates", "range_high"], ["above"]),
        node("Max", ["below", "above"], ["beyond_range"]),
        node("ReduceMax", ["beyond_range"], ["greatest"], axes=[1], keepdims=1),
        node("Div", ["greatest", "range_noise_px"], ["excess"]),
        node("MatMul", ["coordinates", "range_back"], ["explained"]),
        node("Sub", ["centred", "explained"], ["rest"]),
        node("Mul", ["rest", "rest"], ["rest_squared"]),
        node("ReduceMean", ["rest_squared"], ["rest_mean_square"], axes=[1], keepdims=1),
        node("Sqrt", ["rest_mean_square"], ["rest_rms"]),
        node("Sub", ["rest_rms", "range_rest_mean_px"], ["rest_above"]),
        node("Div", ["rest_above", "range_rest_sd_px"], ["rest_score"]),
    ]
    return nodes, arrays


def _pose_nodes(count: int) -> list[NodeProto]:
    """The estimated pose (of so many components) against the trained ones, and the verdict over all of the score."""
    from onnx import helper

    node = helper.make_node
    names = ["rx", "ry", "z", *(f"further_{k}" for k in range(3, count))]
    return [
        node("Split", [POSE], names, axis=1),
        node("Split", ["scale_squared"], [f"{name}_scale" for name in names], axis=1),
        node("Mul", ["rx", "rx"], ["rx_squared"]),
        node("Mul", ["ry", "ry"], ["ry_squared"]),
        node("Add", ["rx_squared", "ry_squared"], ["tilt_squared"]),
        node("Sqrt", ["tilt_squared"], ["tilt"]),
        node("Mean", ["rx_scale", "ry_scale"], ["tilt_variance"]),
        node("Sqrt", ["tilt_variance"], ["tilt_scale"]),
        node("Sub", ["tilt", "range_tilt_deg"], ["too_steep"]),
        node("Div", ["too_steep", "tilt_scale"], ["tilt_score"]),
        node("Sub", ["range_min_depth_mm", "z"], ["too_shallow"]),
        node("Sub", ["z", "range_max_depth_mm"], ["too_deep"]),
        node("Max", ["too_shallow", "too_deep"], ["depth_excess"]),
        node("Sqrt", ["z_scale"], ["depth_scale"]),
        node("Div", ["depth_excess", "depth_scale"], ["depth_score"]),
        node("Max", ["excess", "rest_score", "tilt_score", "depth_score"], ["range_score"]),
        node("Greater", ["range_score", "range_threshold"], ["flags"]),
        node("Squeeze", ["flags", "column"], [OUT_OF_DISTRIBUTION]),
    ]


def _to_hinges(depths: FloatArray, values: FloatArray) -> FloatArray:
    """Changes of slope (d, 3) at the depths of a function that is linear between them and level outside."""
    slope = np.diff(values, axis=0) / np.diff(depths)[:, None]
    level = np.zeros((1, values.shape[1]))
    return np.diff(np.concatenate([level, slope, level]), axis=0)


def _from_hinges(depths: FloatArray, first: FloatArray, hinges: FloatArray) -> FloatArray:
    """Values (d, 3) at the depths: what `_to_hinges` was made from."""
    beyond: FloatArray = np.maximum(depths[:, None] - depths, 0.0)
    return first + beyond @ hinges


def _single(values: FloatArray) -> NDArray[np.float32]:
    return values.astype(np.float32)
