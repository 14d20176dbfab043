"""Forces in the ONNX file of an estimator: outputs beside the pose, which itself stays as it was.

force_n            (n, 3) float, N in the wall's axes: along x, along y, normal (`palpate.learn.force`)
force_half_width_n (n, 3) float, of their intervals
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import MissingExtraError
from palpate.dataset import Dataset
from palpate.learn.force import FORCE_AXES, ForceHead, train_forces
from palpate.learn.interval_graph import POSE
from palpate.learn.io import INPUT, graph_of, tensor_of

if TYPE_CHECKING:
    from onnx import NodeProto

FORCE, FORCE_HALF_WIDTH = "force_n", "force_half_width_n"
"""Names of the outputs."""
_OWN = "force/"
"""What the head's names in the graph begin with."""


def train_force_output(estimator: Path, dataset: Dataset, path: Path, seed: int = 0, device: str = "cpu") -> None:
    """Train forces and write an estimator's file anew to `path`, telling them; their errors stand in its metadata.

    Parameters
    ----------
    estimator
        Its file; the pose that it tells stays as it is.
    dataset
        The images that it was trained on, with their forces.
    path
        File to write.
    seed, device
        Of the training.

    Raises
    ------
    PalpateError
        If the dataset has no forces.
    MissingExtraError
        If torch or onnx is not installed.
    """
    add_forces(estimator, train_forces(dataset, seed, device), path)


def add_forces(estimator: Path, head: ForceHead, path: Path) -> None:
    """Write an estimator's file anew to `path`, with the outputs of a head."""
    try:
        import onnx
        from onnx import TensorProto, helper
    except ImportError as error:
        raise MissingExtraError("onnx", "predict") from error
    model = onnx.load_model_from_string(estimator.read_bytes())
    nodes, constants = _nodes(head)
    model.graph.node.extend(nodes)
    model.graph.initializer.extend(tensor_of(name, values) for name, values in constants.items())
    model.graph.output.extend(
        helper.make_tensor_value_info(name, TensorProto.FLOAT, ["image", 3]) for name in (FORCE, FORCE_HALF_WIDTH)
    )
    said = {
        "outputs": list(FORCE_AXES),
        "level": head.level,
        "version": head.network.version,
        **head.validation_error,
    }
    entry = model.metadata_props.add()
    entry.key, entry.value = "forces", json.dumps(said)
    path.write_bytes(model.SerializeToString(deterministic=True))


def _nodes(head: ForceHead) -> tuple[list[NodeProto], dict[str, NDArray[Any]]]:
    from onnx import helper

    nodes, constants = graph_of(head.network)
    names = {_OWN + POSE: FORCE, _OWN + INPUT: INPUT}
    for node in nodes:
        for words in (node.input, node.output):
            own = [names.get(_OWN + word, _OWN + word) for word in words]
            del words[:]
            words.extend(own)
    arrays = {_OWN + name: values for name, values in constants.items()}
    arrays |= {
        _OWN + "normal": np.array([2]),
        _OWN + "floor": head.floor.astype(np.float32),
        _OWN + "share": head.share.astype(np.float32),
    }
    more = [
        helper.make_node("Gather", [FORCE, _OWN + "normal"], [_OWN + "pushed"], axis=1),
        helper.make_node("Abs", [_OWN + "pushed"], [_OWN + "size"]),
        helper.make_node("Mul", [_OWN + "size", _OWN + "share"], [_OWN + "part"]),
        helper.make_node("Add", [_OWN + "part", _OWN + "floor"], [FORCE_HALF_WIDTH]),
    ]
    return nodes + more, arrays
