import json
import subprocess
import sys

import numpy as np
import onnx
import pytest
from synthetic import make_dataset

from errors import refused
from palpate.learn import TrainingSpec, calibrate_interval, fit_ridge, read_estimator, train, write_estimator


@pytest.fixture
def path(tmp_path):
    write_estimator(tmp_path / "estimator.onnx", fit_ridge(make_dataset()))
    return tmp_path / "estimator.onnx"


def rewrite(path, change):
    model = onnx.load(path)
    change(model)
    path.write_bytes(model.SerializeToString())


def set_property(model, key, value):
    next(item for item in model.metadata_props if item.key == key).value = value


def test_file_gives_the_same_estimator_back(path):
    dataset = make_dataset()
    one, again = fit_ridge(dataset), read_estimator(path)
    assert again.predict(dataset.images_px) == pytest.approx(one.predict(dataset.images_px), abs=1e-5)
    assert np.array_equal(one.rest_px, again.rest_px)
    names = ("seed", "made_by", "training_images", "validation_images", "history", "version", "normalisation")
    for name in (*names, "repeat_rmse_deg"):
        assert getattr(one, name) == getattr(again, name), name


@pytest.mark.parametrize("activation", ["relu", "silu"])
def test_deep_networks_come_back(tmp_path, activation):
    dataset = make_dataset()
    one = train(dataset, TrainingSpec(epochs=3, layers=2, width=16, activation=activation, repeats=2))
    write_estimator(tmp_path / "estimator.onnx", one)
    again = read_estimator(tmp_path / "estimator.onnx")
    assert again.predict_members(dataset.images_px) == pytest.approx(one.predict_members(dataset.images_px), abs=1e-5)
    assert again.repeat_rmse_deg == one.repeat_rmse_deg
    assert len(again.repeat_rmse_deg) == 2


def test_file_passes_the_checker_of_onnx_and_is_the_same_every_time(path, tmp_path):
    onnx.checker.check_model(onnx.load(path), full_check=True)
    write_estimator(tmp_path / "again.onnx", fit_ridge(make_dataset()))
    assert (tmp_path / "again.onnx").read_bytes() == path.read_bytes()


def test_file_names_outputs_units_and_the_order_of_the_markers(path):
    report = {item.key: item.value for item in onnx.load(path).metadata_props}
    assert json.loads(report["outputs"]) == ["rx_deg", "ry_deg", "depth_mm"]
    assert json.loads(report["units"]) == {"markers_px": "px", "rx_deg": "deg", "ry_deg": "deg", "depth_mm": "mm"}
    assert json.loads(report["marker_order_px"]) == make_dataset().rest_px.tolist()
    assert json.loads(report["scale_px"]) == [173.0, 130.0]


@pytest.mark.parametrize(("key", "value"), [("format_version", "0"), ("format", "other")])
def test_another_format_is_refused(path, key, value):
    rewrite(path, lambda model: set_property(model, key, value))
    with refused("model-version"):
        read_estimator(path)


def test_a_weight_that_is_not_a_number_is_refused(path):
    def spoil(model):
        weight = next(item for item in model.graph.initializer if item.name == "weight_0")
        values = onnx.numpy_helper.to_array(weight).copy()
        values[0, 0, 0] = np.nan
        weight.CopyFrom(onnx.numpy_helper.from_array(values, "weight_0"))

    rewrite(path, spoil)
    with refused("model-not-finite"):
        read_estimator(path)


@pytest.mark.parametrize("key", ["made_by", "scale_px", "marker_order_px"])
def test_metadata_that_is_no_json_is_refused(path, key):
    rewrite(path, lambda model: set_property(model, key, "{"))
    with refused("model-unreadable"):
        read_estimator(path)


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", "model-version"),
        (b"cos\nsystem\n(S'touch /tmp/never'\ntR.", "model-unreadable"),
        (b"\x00" * 40, "model-unreadable"),
    ],
)
def test_a_pickle_is_not_opened(tmp_path, content, code):
    path = tmp_path / "estimator.onnx"
    path.write_bytes(content)
    with refused(code, "estimator.onnx"):
        read_estimator(path)


def test_weights_in_another_file_are_not_fetched(path):
    def point_elsewhere(model):
        weight = next(item for item in model.graph.initializer if item.name == "weight_0")
        weight.ClearField("raw_data")
        weight.data_location = onnx.TensorProto.EXTERNAL
        weight.external_data.add(key="location", value="/etc/hostname")

    rewrite(path, point_elsewhere)
    with refused("model-unreadable"):
        read_estimator(path)


def test_reading_needs_no_torch(path):
    code = (
        "import sys; sys.modules['torch'] = None\n"
        "from pathlib import Path; from palpate.learn import open_predictor, read_estimator\n"
        f"read_estimator(Path({str(path)!r})); print(open_predictor(Path({str(path)!r})).markers)"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "12"


def test_the_interval_comes_back_with_its_presses(tmp_path):
    dataset = make_dataset(presses=200)
    one = calibrate_interval(fit_ridge(dataset), dataset)
    write_estimator(tmp_path / "estimator.onnx", one)
    onnx.checker.check_model(onnx.load(tmp_path / "estimator.onnx"), full_check=True)
    again = read_estimator(tmp_path / "estimator.onnx")
    assert again.interval.presses == one.interval.presses
    assert again.interval.error == pytest.approx(one.interval.error, rel=1e-5)
    found, expected = again.estimate(dataset.images_px), one.estimate(dataset.images_px)
    assert found.half_width == pytest.approx(expected.half_width, rel=1e-4)
    assert np.array_equal(found.out_of_distribution, expected.out_of_distribution)
