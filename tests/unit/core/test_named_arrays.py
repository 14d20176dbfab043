"""Named arrays in a file: what is written is read again, and what is damaged is refused."""

from pathlib import Path

import numpy as np

from palpate.core.named_arrays import read_arrays, write_arrays


def test_arrays_of_every_kind_come_back(tmp_path: Path) -> None:
    arrays = {
        "floats": np.linspace(-1, 1, 7).reshape(7, 1),
        "none": np.zeros((0, 2)),
        "bytes": np.arange(6, dtype=np.uint8).reshape(2, 3),
        "flags": np.array([True, False]),
        "texts": np.array(["", "grün", "a" * 40]),
        "one": np.array(3),
    }
    write_arrays(tmp_path / "a.h5", arrays)
    again = read_arrays(tmp_path / "a.h5")
    assert again.keys() == arrays.keys()
    for name, values in arrays.items():
        assert again[name].tolist() == values.tolist()
        assert again[name].shape == values.shape
        assert again[name].dtype.kind == values.dtype.kind
