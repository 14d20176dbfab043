"""Configuration of the training of estimators."""

from __future__ import annotations

from typing import Literal

from palpate.core import PAPER, Spec, parameter


class TrainingSpec(Spec):
    """Architecture and training of a multilayer perceptron.

    The defaults are the preset ``quick``. `paper_training` gives the protocol of the paper.
    """

    layers: int = parameter(3, unit="1", meaning="number of hidden layers", ge=1, le=10)
    width: int = parameter(128, unit="1", meaning="units per hidden layer", ge=4, le=4096)
    dropout: float = parameter(0.0, unit="1", meaning="dropout rate of hidden units", ge=0, lt=1)
    activation: Literal["relu", "silu"] = parameter("silu", unit="", meaning="activation of the hidden layers")
    components: int = parameter(
        48, unit="1", meaning="number of principal components at the input; 0: marker coordinates", ge=0, le=4096
    )
    clean_share: float = parameter(0.5, unit="1", meaning="share of each batch without jitter", ge=0, le=1)
    repeats: int = parameter(
        3, unit="1", meaning="number of trainings, each with its own seed", ge=1, le=64, source=PAPER
    )
    members: Literal["all", "best"] = parameter(
        "all", unit="", meaning="average all repeats, or keep the repeat with the smallest validation error"
    )
    schedule: Literal["cosine", "plateau"] = parameter(
        "cosine",
        unit="",
        meaning="cosine: the learning rate decreases to 0, and the last weights are kept; plateau: the learning rate "
        "drops and training stops by the validation error with jitter, and the best weights are kept",
    )
    learning_rate: float = parameter(2e-3, unit="1", meaning="initial learning rate of Adam", gt=0, le=1)
    matrix_rate: float = parameter(
        0.05, unit="1", meaning="initial learning rate of hidden weights by Muon; 0: all by Adam", ge=0, le=1
    )
    batch: int = parameter(512, unit="1", meaning="images per batch", ge=1, le=65536)
    epochs: int = parameter(
        60, unit="1", meaning="maximum number of passes over the training images", ge=1, le=100_000
    )
    plateau_patience: int = parameter(
        100, unit="1", meaning="epochs without progress before the learning rate drops", ge=1, source=PAPER
    )
    plateau_factor: float = parameter(
        0.1, unit="1", meaning="factor by which the learning rate drops", gt=0, lt=1, source=PAPER
    )
    stopping_patience: int = parameter(
        75, unit="1", meaning="epochs without progress before training stops", ge=1, source=PAPER
    )


class LearningSpec(Spec):
    """Method, device and seed of the training of a design's estimator.

    ``"quick"`` trains three networks with default settings, in seconds; their mean is the estimate. ``"best"``
    selects settings by Bayesian optimisation with pruning, and trains the winner longer. ``"paper"`` searches the
    paper's Table 1 by Bayesian optimisation with the training protocol printed in the paper.
    """

    preset: Literal["quick", "best", "paper"] = parameter(
        "quick", unit="", meaning="method of training: quick, best or paper"
    )
    trials: int | None = parameter(
        None,
        unit="1",
        meaning="number of evaluated settings; empty: 30 of 72 (paper), 9 of 36 (best)",
        ge=1,
        le=100_000,
    )
    seed: int = parameter(0, unit="1", meaning="seed of weights, batches, jitter and trials", ge=0)
    device: Literal["cpu", "cuda", "auto"] = parameter(
        "cpu", unit="", meaning="device of the training; auto: CUDA if available"
    )


def paper_training(layers: int, width: int, dropout: float) -> TrainingSpec:
    """Return the training protocol of Zaid et al. 2024 for one setting of its Table 1.

    As printed: Adam at 1e-4, a drop by a factor of ten after 100 epochs without progress, and a stop after 75, hence
    never a drop. Batch size, activation and maximum number of epochs are not printed; 64, ReLU and 2 000 are used.
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
        matrix_rate=0.0,
        batch=64,
        epochs=2000,
    )
