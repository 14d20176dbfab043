import h5py
import numpy as np
import pytest
from synthetic import make_dataset

from palpate.core import PalpateError
from palpate.learn import fit_ridge, read_estimator, write_estimator


@pytest.fixture
def path(tmp_path):
    write_estimator(tmp_path / "estimator.h5", fit_ridge(make_dataset()))
    return tmp_path / "estimator.h5"


def test_file_gives_the_same_estimator_back(path):
    dataset = make_dataset()
    one, again = fit_ridge(dataset), read_estimator(path)
    assert np.array_equal(one.predict(dataset.images_px), again.predict(dataset.images_px))
    assert np.array_equal(one.rest_px, again.rest_px)
    names = ("seed", "made_by", "training_images", "validation_images", "history", "version", "normalisation")
    for name in names:
        assert getattr(one, name) == getattr(again, name), name


def test_file_names_outputs_with_units(path):
    with h5py.File(path) as file:
        assert list(file.attrs["outputs"]) == ["rx_deg", "ry_deg", "depth_mm"]


def test_another_version_is_refused(path):
    with h5py.File(path, "a") as file:
        file.attrs["version"] = "0"
    with pytest.raises(PalpateError, match="is not an estimator of version"):
        read_estimator(path)


def test_a_weight_that_is_not_a_number_is_refused(path):
    with h5py.File(path, "a") as file:
        file["layer_0/weight"][0, 0, 0] = np.nan
    with pytest.raises(PalpateError, match="not a number"):
        read_estimator(path)


def test_a_pickle_is_not_opened(tmp_path):
    path = tmp_path / "estimator.h5"
    path.write_bytes(b"cos\nsystem\n(S'touch /tmp/never'\ntR.")
    with pytest.raises(PalpateError, match="is not an estimator"):
        read_estimator(path)
