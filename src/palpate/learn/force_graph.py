"""Forces in the ONNX file of an estimator: additional outputs; the pose does not change.

force_n            (n, 3) float, N in the wall's axes: along x, along y, normal (`palpate.learn.force`)
force_half_width_n (n, 3) float, of their intervals
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from palpate.core import load_extra
from palpate.datasets import Dataset
from palpate.learn.force import FORCE_AXES, ForceHead, train_forces
from palpate.learn.graph import build_model
from palpate.learn.io import INPUT, network_graph

FORCE, FORCE_HALF_WIDTH = "force_n", "force_half_width_n"
"""Names of the outputs."""
_OWN = "force_network_"
"""Prefix of the remaining node names."""


def train_force_output(estimator: Path, dataset: Dataset, path: Path, seed: int = 0, device: str = "cpu") -> None:
    """Train forces and write the estimator with force outputs to `path`; its metadata contain the errors.

    Parameters
    ----------
    estimator
        Its file; its pose does not change.
    dataset
        The images that it was trained on, with their forces.
    path
        File to write.
    seed, device
        Seed and device of the training.

    Raises
    ------
    PalpateError
        If the dataset has no forces.
    MissingExtraError
        If torch or onnx is not installed.
    """
    add_forces(estimator, train_forces(dataset, seed, device), path)


def add_forces(estimator: Path, head: ForceHead, path: Path) -> None:
    """Write an estimator with the outputs of a force head to `path`."""
    onnx = load_extra("onnx", "predict")
    model = onnx.load_model_from_string(estimator.read_bytes())
    body, arrays = network_graph(head.network, _OWN, FORCE)
    arrays |= {
        f"{_OWN}normal": np.array([2]),
        f"{_OWN}floor": head.floor.astype(np.float32),
        f"{_OWN}share": head.share.astype(np.float32),
    }
    body += f"""
        {_OWN}push = Gather <axis = 1> ({FORCE}, {_OWN}normal)
        {_OWN}size = Abs ({_OWN}push)
        {_OWN}part = Mul ({_OWN}size, {_OWN}share)
        {FORCE_HALF_WIDTH} = Add ({_OWN}part, {_OWN}floor)"""
    markers = len(head.network.rest_px)
    signature = f"(double[image,{markers},2] {INPUT}) => (float[image,3] {FORCE}, float[image,3] {FORCE_HALF_WIDTH})"
    forces = build_model(f"force {signature}", body, arrays).graph
    for part in ("node", "initializer", "output"):
        getattr(model.graph, part).extend(getattr(forces, part))
    said = {
        "outputs": list(FORCE_AXES),
        "level": head.level,
        "version": head.network.version,
        **head.validation_error,
    }
    entry = model.metadata_props.add()
    entry.key, entry.value = "forces", json.dumps(said)
    path.write_bytes(model.SerializeToString(deterministic=True))
