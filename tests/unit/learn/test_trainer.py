"""The training loop goes on from a checkpoint as if it had not been interrupted."""

import numpy as np
import pytest

from needs import needs

torch = needs("torch")
from palpate.learn.trainer import Trainer, TrainerSpec, TrainingTask  # noqa: E402

SPEC = TrainerSpec(epochs=12, batch=4, learning_rate=0.1, weight_decay=0.0, anchor_weight=0.01, stopping_patience=2)


class Line(TrainingTask):
    """Three slopes (r, 1, 1) of one line; the first starts at its best and stops soon."""

    def __init__(self) -> None:
        self.parameters = [torch.tensor([[[2.0]], [[0.0]], [[-3.0]]], requires_grad=True)]
        self.rows = torch.arange(16)
        self.x = torch.linspace(-1.0, 1.0, 16)[:, None]

    def draw(self, rows, done, random):
        return self.x[rows], 2.0 * self.x[rows]

    def forward(self, parameters, inputs, random):
        return inputs @ parameters[0]

    def validation(self):
        return [(self.x[None], 2.0 * self.x)]


def streams():
    return [torch.Generator().manual_seed(number) for number in range(3)]


def test_members_that_have_stopped_do_not_disturb_the_others_after_a_break(tmp_path, monkeypatch):
    whole = Trainer(Line(), SPEC, streams()).run()
    path = tmp_path / "checkpoint.pt"
    monkeypatch.setattr("palpate.learn.trainer._BETWEEN_S", -1.0)
    broken = Trainer(Line(), SPEC, streams())
    train, epochs = broken._train, []

    def stop() -> None:
        epochs.append(len(broken.active))
        if len(epochs) > 6:
            raise KeyboardInterrupt
        train()

    monkeypatch.setattr(broken, "_train", stop)
    with pytest.raises(KeyboardInterrupt):
        broken.run(path)
    assert epochs[-1] < 3  # a member has stopped before the break
    resumed = Trainer(Line(), SPEC, streams()).run(path)
    for one, other in zip(whole, resumed, strict=True):
        assert one.errors == other.errors
        assert np.array_equal(one.state[0].numpy(), other.state[0].numpy())
