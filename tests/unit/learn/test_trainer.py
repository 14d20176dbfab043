"""The training loop goes on from a checkpoint as if it had not been interrupted."""

import numpy as np
import pytest

from needs import needs
from palpate.learn import TrainingSpec
from palpate.learn.components import PrincipalComponents
from palpate.learn.training_set import TrainingSet

torch = needs("torch")
from palpate.learn.network import train_network  # noqa: E402
from palpate.learn.trainer import Trainer, TrainerSpec, TrainingTask, orthogonalise  # noqa: E402

SPEC = TrainerSpec(epochs=12, batch=4, learning_rate=0.1, weight_decay=0.0, anchor_weight=0.01, stopping_patience=2)
TRAINED = np.arange(64) < 48


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


@pytest.mark.parametrize("shape", [(12, 30), (30, 12)])
def test_an_orthogonalised_matrix_keeps_its_singular_vectors_and_evens_its_singular_values(shape):
    rng = np.random.default_rng(3)
    left, right = (np.linalg.qr(rng.normal(size=(n, 12)))[0] for n in shape)
    values = np.geomspace(1.0, 0.2, 12)
    given = np.stack([left * values @ right.T, 1e-3 * left * values @ right.T])
    found = orthogonalise(torch.as_tensor(given)).numpy()
    inside = left.T @ found @ right
    for one in inside:
        assert np.abs(one - np.diag(np.diag(one))).max() < 1e-6
        assert np.diag(one).min() > 0.5
        assert np.diag(one).max() < 1.25
    assert inside[0] == pytest.approx(inside[1], abs=1e-4), "the scale of a gradient does not matter"


def test_members_train_alike_alone_and_together_by_muon():
    samples = TrainingSet(
        np.random.default_rng(0).normal(size=(64, 6)), np.eye(3)[np.arange(64) % 3], TRAINED, ~TRAINED
    )
    whole = PrincipalComponents(np.zeros(6), np.eye(6))
    spec = TrainingSpec(epochs=3, batch=16, width=8, layers=2, repeats=2)
    both, alone = (
        train_network(samples, np.zeros(6), whole, spec.model_copy(update={"repeats": repeats})) for repeats in (2, 1)
    )
    for one, other in zip(both[0].state, alone[0].state, strict=True):
        assert one.numpy() == pytest.approx(other.numpy(), abs=1e-5)
    adam = train_network(samples, np.zeros(6), whole, spec.model_copy(update={"matrix_rate": 0.0}))
    assert not np.allclose(adam[0].state[0], both[0].state[0], atol=1e-3)


@pytest.mark.parametrize(("clean", "jittered"), [(0.5, 200), (1.0, 0), (0.25, 300)])
def test_jitter_is_uniform_within_its_half_width_on_its_share_of_a_batch(
    clean: float, jittered: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Uniform numbers of half-width h have the extremes -h and h and the standard deviation h / sqrt(3)."""
    tasks, half = [], np.array([1.0, 3.0])
    monkeypatch.setattr(Trainer, "run", lambda self: tasks.append(self.task) or [])
    samples = TrainingSet(np.zeros((400, 2)), np.zeros((400, 1)), np.arange(400) >= 0, np.arange(400) < 1)
    inside = PrincipalComponents(np.zeros(2), np.eye(2))
    train_network(samples, half, inside, TrainingSpec(clean_share=clean, width=4, repeats=1))
    inputs, _ = tasks[0].draw(torch.arange(400)[None], 0.0, tasks[0].random)
    noise = inputs[0].numpy()
    assert (noise != 0).all(axis=1).sum() == jittered
    assert (noise[:jittered] != 0).all()
    if jittered:
        assert np.abs(noise).max(axis=0) == pytest.approx(half, rel=0.03)
        assert (np.abs(noise) <= half).all()
        assert noise[:jittered].std(axis=0) == pytest.approx(half / np.sqrt(3.0), rel=0.1)
