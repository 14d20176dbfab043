"""Interval as part of the ONNX graph, so that any runtime computes it with the pose.

    half_width (n, 3) float, in the pose's units:  factor · sqrt( var over members + error(depth)² )
    out_of_distribution (n,) bool:                 score of the displacement > threshold

The error by depth is linear between knots, hence a sum of hinges: error(z) = e₀ + Σ cᵢ max(z − zᵢ, 0).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray
from palpate.learn.interval import Interval, TrainedRange

Arrays = dict[str, NDArray[Any]]

POSE, MEMBERS, HALF_WIDTH, OUT_OF_DISTRIBUTION = "pose", "member_poses", "half_width", "out_of_distribution"
"""Names of the graph's outputs: mean over the members, each member (r, n, 3), half-widths, flags."""
INTERVAL_NODES = """
    apart = Sub (member_poses, pose)
    apart_squared = Mul (apart, apart)
    spread_squared = ReduceMean <axes = [0], keepdims = 0> (apart_squared)
    depth = Gather <axis = 1> (pose, depth_axis)
    beyond = Sub (depth, error_depths)
    hinges = Relu (beyond)
    error_change = MatMul (hinges, error_hinges)
    error = Add (error_change, error_first)
    error_squared = Mul (error, error)
    scale_squared = Add (spread_squared, error_squared)
    error_scale = Sqrt (scale_squared)
    half_width = Mul (error_scale, factor)
    moved_single = Cast <to = 1> (moved_px)
    displacement = Reshape (moved_single, flat)
    centred = Sub (displacement, range_centre)
    coordinates = MatMul (centred, range_directions)
    below = Sub (range_low, coordinates)
    above = Sub (coordinates, range_high)
    beyond_range = Max (below, above)
    largest = ReduceMax <axes = [1], keepdims = 1> (beyond_range)
    excess = Div (largest, range_noise_px)
    explained = MatMul (coordinates, range_back)
    rest = Sub (centred, explained)
    rest_squared = Mul (rest, rest)
    rest_mean_square = ReduceMean <axes = [1], keepdims = 1> (rest_squared)
    rest_rms = Sqrt (rest_mean_square)
    rest_above = Sub (rest_rms, range_rest_mean_px)
    rest_score = Div (rest_above, range_rest_sd_px)
    wall_pose = Gather <axis = 1> (pose, columns)
    wall_scale = Gather <axis = 1> (scale_squared, columns)
    rx, ry, z = Split <axis = 1> (wall_pose)
    rx_scale, ry_scale, z_scale = Split <axis = 1> (wall_scale)
    rx_squared = Mul (rx, rx)
    ry_squared = Mul (ry, ry)
    tilt_squared = Add (rx_squared, ry_squared)
    tilt = Sqrt (tilt_squared)
    tilt_variance = Mean (rx_scale, ry_scale)
    tilt_scale = Sqrt (tilt_variance)
    too_steep = Sub (tilt, range_tilt_deg)
    tilt_score = Div (too_steep, tilt_scale)
    too_shallow = Sub (range_min_depth_mm, z)
    too_deep = Sub (z, range_max_depth_mm)
    depth_excess = Max (too_shallow, too_deep)
    depth_scale = Sqrt (z_scale)
    depth_score = Div (depth_excess, depth_scale)
    range_score = Max (excess, rest_score, tilt_score, depth_score)
    flags = Greater (range_score, range_threshold)
    out_of_distribution = Squeeze (flags, column)
"""
"""Nodes after those of the pose: formulas of `Interval` and `TrainedRange`."""

_FIELDS = [item.name for item in fields(TrainedRange)]
_VECTORS, _SCALARS = _FIELDS[:4], _FIELDS[4:]


def describe_interval(interval: Interval) -> dict[str, Any]:
    """Describe the interval for the metadata, as JSON data without arrays."""
    trained = {name: getattr(interval.trained, name) for name in _SCALARS}
    return {"level": interval.level, "presses": list(interval.presses), "trained_range": trained}


def read_interval(content: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Interval:
    """Build the interval from its description and the arrays of the graph."""
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


def interval_arrays(interval: Interval) -> Arrays:
    """Arrays that the nodes of `INTERVAL_NODES` read."""
    trained = interval.trained
    arrays: Arrays = {f"range_{name}": _single(getattr(trained, name)) for name in _VECTORS}
    arrays |= {f"range_{name}": _single(np.array(getattr(trained, name))) for name in _SCALARS[:-1]}
    return arrays | {
        "column": np.array([1]),
        "columns": np.array([0, 1, 2]),
        "range_back": _single(trained.directions.T),
        "depth_axis": np.array([2]),
        "error_depths": _single(interval.depths_mm),
        "error_first": _single(interval.error[0]),
        "error_hinges": _single(_to_hinges(interval.depths_mm, interval.error)),
        "factor": _single(interval.factor),
    }


def _to_hinges(depths: FloatArray, values: FloatArray) -> FloatArray:
    """Changes of slope (d, 3) at the depths of a function that is linear between them and level outside."""
    slope = np.diff(values, axis=0) / np.diff(depths)[:, None]
    level = np.zeros((1, values.shape[1]))
    return np.diff(np.concatenate([level, slope, level]), axis=0)


def _from_hinges(depths: FloatArray, first: FloatArray, hinges: FloatArray) -> FloatArray:
    """Values (d, 3) at the depths: the inverse of `_to_hinges`."""
    beyond: FloatArray = np.maximum(depths[:, None] - depths, 0.0)
    return first + beyond @ hinges


def _single(values: FloatArray) -> NDArray[np.float32]:
    return values.astype(np.float32)
