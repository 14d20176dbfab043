"""Training of an estimator from a dataset: a perceptron, or ridge regression as its baseline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from palpate.core import FloatArray, generator, load_extra
from palpate.datasets import Dataset, draw_jitter
from palpate.learn.components import PrincipalComponents, find_components
from palpate.learn.estimator import Estimator
from palpate.learn.metrics import Metrics, measure_errors
from palpate.learn.ridge import solve_ridge
from palpate.learn.spec import TrainingSpec
from palpate.learn.training_set import TrainingSet


def train(
    dataset: Dataset,
    spec: TrainingSpec = TrainingSpec(),  # noqa: B008  (a spec is frozen)
    seed: int = 0,
    device: str = "cpu",
) -> Estimator:
    """Train perceptrons on the images that are not held out.

    New jitter is drawn for every image in every epoch, in pixels and before normalisation.

    Parameters
    ----------
    dataset
        Clean images with their poses and split.
    spec
        Shape of the network and how it is trained.
    seed
        Seed of weights, order of images, jitter and dropout.
    device
        ``"cpu"`` or ``"cuda"``.

    Returns
    -------
    Estimator
        The repeats, or the best of them.

    Raises
    ------
    MissingExtraError
        If torch is not installed.
    """
    return train_on(dataset.subset(validation=False), dataset.subset(validation=True), spec, seed, device)


def train_on(
    checkpoint: Dataset,
    held: Dataset,
    spec: TrainingSpec,
    seed: int = 0,
    device: str = "cpu",
    targets: tuple[FloatArray, FloatArray] | None = None,
) -> Estimator:
    """Train on the images of `checkpoint`, and select epochs and repeats by those of `held`; see `train`.

    `targets` (n, 3) and (m, 3) replace their poses. The caller ensures that they share no press: `train` takes them
    from one dataset.
    """
    load_extra("torch", "learn")
    from palpate.learn.network import collect_layers, train_network

    noisy = draw_jitter(held.images_px, checkpoint.spec.jitter_px, generator(seed, "judge"))
    images = np.concatenate([checkpoint.images_px, noisy])
    inside = np.arange(len(images)) < len(checkpoint.images_px)
    samples = TrainingSet(
        _normalised(checkpoint, images),
        np.concatenate(targets or (checkpoint.poses, held.poses)),
        inside,
        ~inside,
        seed,
    )
    jitter, (mean, sd) = _jitter(checkpoint), samples.scale
    components = _components(samples.inputs[inside], jitter, spec.components)
    trained = train_network(samples, jitter, components, spec, device)
    weights, biases = collect_layers(trained)
    first, first_bias = components.fold(weights[0], biases[0])
    estimator = Estimator(
        normalisation=checkpoint.normalisation,
        weights=(first, *weights[1:]),
        biases=(first_bias, *biases[1:]),
        activation=spec.activation,
        output_mean=mean,
        output_sd=sd,
        rest_px=checkpoint.rest_px,
        seed=seed,
        made_by={"method": "perceptron", "device": device, **spec.model_dump(mode="json")},
        training_images=len(checkpoint.poses),
        validation_images=len(held.poses),
        history=tuple(tuple(member.errors) for member in trained),
        space=checkpoint.space,
    )
    if targets is None:
        single = [measure_errors(one, held.poses, held.space) for one in estimator.predict_members(held.images_px)]
        estimator = replace(estimator, repeat_rmse_deg=tuple(one.pooled.rmse for one in single))
    if spec.members == "all":
        return estimator
    return estimator.keep_members([int(np.argmin([member.errors[member.best_epoch] for member in trained]))])


def fit_ridge(dataset: Dataset) -> Estimator:
    """Fit the best linear estimator under jitter, in closed form.

    Jitter of half-width a adds a²/3 to the variance of every coordinate, so the mean squared error over it is
    minimal for ridge regression with the penalty n a²/3 (Bishop 1995, "Training with noise is equivalent to
    Tikhonov regularization").

    Parameters
    ----------
    dataset
        Clean images with their poses and split; the held-out ones are not used.

    Examples
    --------
    >>> from palpate.datasets import Dataset, DatasetSpec, Normalisation
    >>> rng = np.random.default_rng(0)
    >>> poses = np.column_stack([rng.uniform(-9, 9, (40, 2)), np.full(40, 4.0)])
    >>> moved = (poses @ rng.normal(size=(3, 8))).reshape(40, 4, 2)
    >>> dataset = Dataset(
    ...     spec=DatasetSpec(jitter_px=0.1), images_px=100 + moved, poses=poses, press=np.arange(40),
    ...     validation=np.arange(40) % 5 == 0, branch=np.full(40, "flat"), travel_mm=np.ones(40),
    ...     rest_px=np.full((4, 2), 100.0), image_size_px=(346, 260), solved_presses=1, dropped={},
    ... )
    >>> estimator = fit_ridge(dataset)
    >>> bool(np.abs(estimator.predict(dataset.images_px) - poses).max() < 0.1)
    True
    >>> evaluate(estimator, dataset).images
    8
    """
    kept = dataset.subset(validation=False)
    inputs = _normalised(dataset, kept.images_px)
    every = np.ones(len(inputs), bool)
    samples = TrainingSet(inputs, kept.poses, every, ~every)
    mean, sd = samples.scale
    [(weight, bias)] = solve_ridge(inputs, samples.standardised, [len(inputs) * _jitter(dataset) ** 2 / 3 + 1e-12])
    return Estimator(
        normalisation=dataset.normalisation,
        weights=(weight[None],),
        biases=(bias[None],),
        activation="relu",
        output_mean=mean,
        output_sd=sd,
        rest_px=dataset.rest_px,
        seed=0,
        made_by={"method": "ridge"},
        training_images=len(kept.poses),
        validation_images=int(dataset.validation.sum()),
        space=dataset.space,
    )


def evaluate(estimator: Estimator, dataset: Dataset, jitter_seed: int | None = None) -> Metrics:
    """Measure an estimator on the held-out presses.

    Parameters
    ----------
    estimator
        The estimator.
    dataset
        The dataset that it was trained on, or another of the same layout.
    jitter_seed
        Seed of one draw of the dataset's jitter; `None` evaluates on clean images.
    """
    held = dataset.subset(validation=True)
    images = held.images_px
    if jitter_seed is not None:
        images = draw_jitter(images, dataset.spec.jitter_px, generator(jitter_seed, "evaluate"))
    return measure_errors(estimator.predict(images), held.poses, held.space)


def _components(inputs: FloatArray, jitter: FloatArray, count: int) -> PrincipalComponents:
    """Whitened components of normalised inputs (n, 2m) with jitter (2m,); the inputs for count 0."""
    if count == 0:
        return PrincipalComponents(np.zeros(len(jitter)), np.eye(len(jitter)))
    noise = float(np.mean(jitter**2)) / 3
    covariance = np.cov(inputs, rowvar=False)
    return find_components(inputs.mean(axis=0), covariance, count, lambda variance: np.sqrt(variance + noise))


def _normalised(dataset: Dataset, images_px: FloatArray) -> FloatArray:
    return dataset.normalisation.apply(images_px).reshape(len(images_px), -1)


def _jitter(dataset: Dataset) -> FloatArray:
    """(2m,) half-width of the jitter, normalised."""
    return np.tile(dataset.spec.jitter_px / np.array(dataset.normalisation.scale_px), dataset.images_px.shape[1])
