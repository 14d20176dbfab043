import time

import numpy as np
import pytest
from synthetic import make_dataset

from palpate.core import MissingExtraError, PalpateError
from palpate.learn import TrainSpec, fit_ridge, open_predictor, train, write_estimator


def test_runtime_predicts_what_numpy_predicts(tmp_path):
    dataset = make_dataset(markers=37)
    estimator = train(dataset, TrainSpec(epochs=5))
    write_estimator(tmp_path / "model.onnx", estimator)
    predictor = open_predictor(tmp_path / "model.onnx")
    assert predictor.predict(dataset.images_px) == pytest.approx(estimator.predict(dataset.images_px), abs=1e-5)
    one = predictor.predict(dataset.images_px[:1])
    assert one == pytest.approx(estimator.predict(dataset.images_px[:1]), abs=1e-5)


def test_one_image_of_169_markers_takes_less_than_a_fifth_of_a_millisecond(tmp_path):
    dataset = make_dataset(markers=169)
    write_estimator(tmp_path / "model.onnx", train(dataset, TrainSpec(epochs=1)))
    predictor, image = open_predictor(tmp_path / "model.onnx"), dataset.images_px[:1]
    times = []
    for _ in range(500):
        started = time.perf_counter()
        predictor.predict(image)
        times.append(time.perf_counter() - started)
    assert np.median(times) < 0.2e-3


def test_another_number_of_markers_is_refused(tmp_path):
    write_estimator(tmp_path / "model.onnx", fit_ridge(make_dataset()))
    with pytest.raises(PalpateError, match="the model reads"):
        open_predictor(tmp_path / "model.onnx").predict(np.zeros((1, 11, 2)))


@pytest.mark.parametrize("content", [None, b"", b"not a model"])
def test_what_is_no_model_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / "model.onnx").write_bytes(content)
    with pytest.raises(PalpateError, match="is not an estimator"):
        open_predictor(tmp_path / "model.onnx")


def test_a_missing_runtime_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "onnxruntime", None)
    with pytest.raises(MissingExtraError, match=r"onnxruntime.*palpate\[predict\]"):
        open_predictor(tmp_path / "model.onnx")
