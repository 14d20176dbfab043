import time

import numpy as np
import pytest
from synthetic import make_dataset

from errors import refused
from palpate.learn import TrainingSpec, calibrate_interval, fit_ridge, open_predictor, train, write_estimator


def test_runtime_predicts_what_numpy_predicts(tmp_path):
    dataset = make_dataset(markers=37)
    estimator = train(dataset, TrainingSpec(epochs=5))
    write_estimator(tmp_path / "model.onnx", estimator)
    predictor = open_predictor(tmp_path / "model.onnx")
    assert predictor.predict(dataset.images_px).pose == pytest.approx(estimator.predict(dataset.images_px), abs=1e-5)
    one = predictor.predict(dataset.images_px[:1]).pose
    assert one == pytest.approx(estimator.predict(dataset.images_px[:1]), abs=1e-5)


def test_runtime_gives_the_interval_that_numpy_gives(tmp_path):
    dataset = make_dataset(presses=300, markers=37)
    estimator = calibrate_interval(train(dataset, TrainingSpec(epochs=5)), dataset)
    write_estimator(tmp_path / "model.onnx", estimator)
    predictor = open_predictor(tmp_path / "model.onnx")
    images = np.concatenate([dataset.images_px, dataset.rest_px[None], dataset.images_px[:50] + 15.0])
    found, expected = predictor.predict(images), estimator.estimate(images)
    assert predictor.level == 0.9
    assert found.half_width == pytest.approx(expected.half_width, rel=1e-4)
    assert np.array_equal(found.out_of_distribution, expected.out_of_distribution)
    assert 50 <= found.out_of_distribution.sum() < 100


def test_a_model_without_an_interval_promises_nothing(tmp_path):
    write_estimator(tmp_path / "model.onnx", fit_ridge(make_dataset()))
    predictor = open_predictor(tmp_path / "model.onnx")
    found = predictor.predict(make_dataset().images_px[:3])
    assert predictor.level is None
    assert np.isinf(found.half_width).all()
    assert not found.out_of_distribution.any()


def test_one_image_of_169_markers_takes_less_than_a_fifth_of_a_millisecond(tmp_path):
    dataset = make_dataset(markers=169)
    write_estimator(tmp_path / "model.onnx", calibrate_interval(train(dataset, TrainingSpec(epochs=1)), dataset))
    predictor, image = open_predictor(tmp_path / "model.onnx"), dataset.images_px[:1]
    times = []
    for _ in range(500):
        started = time.thread_time()  # not the clock: other tests run at the same time
        predictor.predict(image)
        times.append(time.thread_time() - started)
    batches = np.median(np.reshape(times, (10, 50)), axis=1)
    assert batches.min() < 0.2e-3


def test_another_number_of_markers_is_refused(tmp_path):
    write_estimator(tmp_path / "model.onnx", fit_ridge(make_dataset()))
    with refused("model-marker-count"):
        open_predictor(tmp_path / "model.onnx").predict(np.zeros((1, 11, 2)))


@pytest.mark.parametrize("content", [None, b"", b"not a model"])
def test_what_is_no_model_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / "model.onnx").write_bytes(content)
    with refused("model-unreadable"):
        open_predictor(tmp_path / "model.onnx")


def test_a_missing_runtime_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "onnxruntime", None)
    with refused("extra-missing", "onnxruntime", ".[predict]"):
        open_predictor(tmp_path / "model.onnx")
