"""What a person may choose about learning."""

from __future__ import annotations

from typing import Literal

from palpate.core import PAPER, Spec, parameter


class TrainingSpec(Spec):
    """One multilayer perceptron, trained several times over, and how.

    The defaults are the preset ``quick``. `paper_training` gives the protocol of the paper.
    """

    layers: int = parameter(3, unit="1", meaning="hidden layers", ge=1, le=10)
    width: int = parameter(128, unit="1", meaning="units of a hidden layer", ge=4, le=4096)
    dropout: float = parameter(0.0, unit="1", meaning="share of hidden units left out while training", ge=0, lt=1)
    activation: Literal["relu", "silu"] = parameter("silu", unit="", meaning="activation of the hidden layers")
    components: int = parameter(
        48, unit="1", meaning="principal components that the network reads; 0: the markers themselves", ge=0, le=4096
    )
    clean_share: float = parameter(0.25, unit="1", meaning="share of each batch that gets no jitter", ge=0, le=1)
    repeats: int = parameter(3, unit="1", meaning="trainings from other seeds", ge=1, le=64, source=PAPER)
    members: Literal["all", "best"] = parameter(
        "all", unit="", meaning="average all repeats, or keep the one best in validation"
    )
    schedule: Literal["cosine", "plateau"] = parameter(
        "cosine",
        unit="",
        meaning="cosine: the learning rate falls to 0 and the last weights are kept, validation unseen; "
        "plateau: it drops and training stops by the jittered validation error, the best weights are kept",
    )
    learning_rate: float = parameter(2e-3, unit="1", meaning="learning rate of Adam at the start", gt=0, le=1)
    batch: int = parameter(256, unit="1", meaning="images of a batch", ge=1, le=65536)
    epochs: int = parameter(160, unit="1", meaning="passes over the training images at most", ge=1, le=100_000)
    plateau_patience: int = parameter(
        100, unit="1", meaning="epochs without progress before the learning rate drops", ge=1, source=PAPER
    )
    plateau_factor: float = parameter(
        0.1, unit="1", meaning="factor of the learning rate's drop", gt=0, lt=1, source=PAPER
    )
    stopping_patience: int = parameter(
        75, unit="1", meaning="epochs without progress before training stops", ge=1, source=PAPER
    )


class LearningSpec(Spec):
    """How an estimator is found for a design.

    ``"quick"`` trains one network of our own choice, in seconds. ``"best"`` chooses among a few such networks by
    Bayesian optimisation with pruning and trains the winner longer. ``"paper"`` searches the paper's Table 1 by
    Bayesian optimisation with the paper's training protocol as printed.
    """

    preset: Literal["quick", "best", "paper"] = parameter("quick", unit="", meaning="way to an estimator")
    trials: int | None = parameter(
        None, unit="1", meaning="settings that are tried; empty: 30 of 72 (paper), 9 of 36 (best)", ge=1, le=100_000
    )
    seed: int = parameter(0, unit="1", meaning="seed of weights, batches, jitter and trials", ge=0)
    device: Literal["cpu", "cuda", "auto"] = parameter(
        "cpu", unit="", meaning="where networks train; auto: on CUDA where there is one"
    )


def paper_training(layers: int, width: int, dropout: float) -> TrainingSpec:
    """Training protocol of Zaid et al. 2024 for one setting of its Table 1.

    As printed: Adam at 1e-4, a drop by ten after 100 epochs without progress and a stop after 75, hence no drop
    ever. Batch size, activation and the most epochs are not printed; ours are 64, ReLU and 2 000.
    """
    return TrainingSpec(
        layers=layers,
        width=width,
        dropout=dropout,
        activation="relu",
        components=0,
        clean_share=0.0,
        members="best",
        schedule="plateau",
        learning_rate=1e-4,
        batch=64,
        epochs=2000,
    )
