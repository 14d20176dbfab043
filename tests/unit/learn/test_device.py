import importlib.util
import sys

import pytest
from synthetic import make_dataset

from errors import refused
from needs import needs
from palpate.learn import TrainingSpec, device, evaluate, find_device, train

torch = needs("torch")


@pytest.mark.parametrize(("has_cuda", "found"), [(True, "cuda"), (False, "cpu")])
def test_auto_takes_cuda_where_there_is_one(monkeypatch, has_cuda, found):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: has_cuda)
    assert find_device("auto") == found
    assert find_device("cpu") == "cpu"


def test_cuda_that_is_not_there_is_refused(monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    with refused("cuda-missing"):
        find_device("cuda")


def test_without_torch_auto_is_the_processor(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.setattr(device.importlib.util, "find_spec", lambda name: None)
    assert find_device("auto") == "cpu"
    assert importlib.util.find_spec("torch") is None


class Factories(torch.overrides.TorchFunctionMode):
    """Notes on which device every new tensor is made."""

    names = frozenset({"as_tensor", "tensor", "zeros", "ones", "empty", "full", "rand", "randn", "randperm"})

    def __init__(self):
        super().__init__()
        self.made = []

    def __torch_function__(self, function, types, args=(), keywords=None):
        if function.__name__ in self.names and "out" not in (keywords or {}):
            self.made.append((function.__name__, str((keywords or {}).get("device"))))
        return function(*args, **(keywords or {}))


@pytest.mark.parametrize("schedule", ["cosine", "plateau"])
def test_every_tensor_of_a_training_is_made_on_the_device_it_is_given(schedule):
    """The first processor by number: torch tells it from a device that nobody named."""
    spec = TrainingSpec(width=4, layers=2, epochs=2, dropout=0.5, schedule=schedule)
    with Factories() as factories:
        train(make_dataset(presses=20), spec, device="cpu:0")
    assert {"as_tensor", "tensor", "zeros", "empty", "randn", "randperm"} <= {name for name, _ in factories.made}
    assert {device for _, device in factories.made} <= {"cpu", "cpu:0"}  # "cpu" is that of another tensor of it


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device")
def test_cuda_learns_as_well_as_the_processor():
    dataset, spec = make_dataset(), TrainingSpec(width=32, epochs=40)
    errors = [evaluate(train(dataset, spec, 1, device=name), dataset).rmse_deg for name in ("cpu", "cuda")]
    assert errors[0] == pytest.approx(errors[1], rel=0.3)
