"""From a dataset to an estimator: a perceptron, or the ridge regression that it must beat."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from palpate.core import FloatArray, child_seed, generator, load_extra
from palpate.dataset import Dataset, draw_jitter
from palpate.learn.components import PrincipalComponents, find_components
from palpate.learn.estimator import Estimator
from palpate.learn.metrics import Metrics, measure_errors
from palpate.learn.ridge import solve_ridge
from palpate.learn.spec import TrainingSpec

if TYPE_CHECKING:
    from palpate.learn.trainer import TrainedState


def train(
    dataset: Dataset,
    spec: TrainingSpec = TrainingSpec(),  # noqa: B008  (a spec is frozen)
    seed: int = 0,
    device: str = "cpu",
) -> Estimator:
    """Train perceptrons on the images that are not held out.

    Jitter is drawn anew for every image in every epoch, in pixels and before normalisation.

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


def train_on(checkpoint: Dataset, held: Dataset, spec: TrainingSpec, seed: int = 0, device: str = "cpu") -> Estimator:
    """Train on the images of `checkpoint` and judge epochs and repeats by those of `held`; for the rest see `train`.

    Nothing says here that the two share no press: `train` takes them from one dataset, which does.
    """
    estimator, trained = train_targets(checkpoint, held, (checkpoint.poses, held.poses), spec, seed, device)
    estimator = replace(estimator, repeat_rmse_deg=_validate_members(estimator, held))
    if spec.members == "all":
        return estimator
    return estimator.keep_members([int(np.argmin([member.errors[member.best_epoch] for member in trained]))])


def train_targets(
    checkpoint: Dataset,
    held: Dataset,
    targets: tuple[FloatArray, FloatArray],
    spec: TrainingSpec,
    seed: int,
    device: str,
) -> tuple[Estimator, list[TrainedState]]:
    """Train on any targets (n, 3) of the images of `checkpoint`; those of `held` choose epochs. All repeats are
    kept."""
    load_extra("torch", "learn")
    from palpate.learn.network import TrainingData, collect_layers, train_network

    inputs = _normalised(checkpoint, checkpoint.images_px)
    jitter = np.tile(
        checkpoint.spec.jitter_px / np.array(checkpoint.normalisation.scale_px), checkpoint.images_px.shape[1]
    )
    components = _components(inputs, jitter, spec.components)
    mean, sd = _standard(targets[0])
    noisy = draw_jitter(held.images_px, checkpoint.spec.jitter_px, generator(seed, "judge"))
    data = TrainingData(
        inputs=inputs,
        targets=(targets[0] - mean) / sd,
        jitter=jitter,
        mean=components.mean,
        projection=components.projection,
        held_inputs=_normalised(checkpoint, noisy),
        held_targets=(targets[1] - mean) / sd,
        device=device,
    )
    trained = train_network(data, spec, [child_seed(seed, "repeat", n) for n in range(spec.repeats)])
    weights, biases = collect_layers(trained)
    first, first_bias = components.fold(weights[0], biases[0])
    return (
        Estimator(
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
        ),
        trained,
    )


def fit_ridge(dataset: Dataset) -> Estimator:
    """Fit the best linear estimator under jitter, in closed form.

    Jitter of half-width a adds a²/3 to the variance of every coordinate, so the mean squared error over it is
    least for ridge regression with the penalty n a²/3 (Bishop 1995, "Training with noise is equivalent to
    Tikhonov regularization").

    Parameters
    ----------
    dataset
        Clean images with their poses and split; the held-out ones are not used.

    Examples
    --------
    >>> from palpate.dataset import Dataset, DatasetSpec, Normalisation
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
    mean, sd = _standard(kept.poses)
    jitter = np.tile(dataset.spec.jitter_px / np.array(dataset.normalisation.scale_px), dataset.images_px.shape[1])
    penalty = len(inputs) * jitter**2 / 3 + 1e-12
    [(weight, bias)] = solve_ridge(inputs, (kept.poses - mean) / sd, [penalty])
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
        What is judged.
    dataset
        The dataset that it was trained on, or another of the same layout.
    jitter_seed
        Seed of one draw of the dataset's jitter; `None` judges on clean images.
    """
    held = dataset.subset(validation=True)
    images = held.images_px
    if jitter_seed is not None:
        images = draw_jitter(images, dataset.spec.jitter_px, generator(jitter_seed, "evaluate"))
    return measure_errors(estimator.predict(images), held.poses, held.space)


def _validate_members(estimator: Estimator, held: Dataset) -> tuple[float, ...]:
    """RMSE of the angle of every member by itself (degrees) on clean images."""
    return tuple(
        measure_errors(poses, held.poses, held.space).pooled.rmse
        for poses in estimator.predict_members(held.images_px)
    )


def _components(inputs: FloatArray, jitter: FloatArray, count: int) -> PrincipalComponents:
    """Whitened components of normalised inputs (n, 2m) with jitter (2m,); the inputs for count 0."""
    if count == 0:
        return PrincipalComponents(np.zeros(len(jitter)), np.eye(len(jitter)))
    noise = float(np.mean(jitter**2)) / 3
    covariance = np.cov(inputs, rowvar=False)
    return find_components(inputs.mean(axis=0), covariance, count, lambda variance: np.sqrt(variance + noise))


def _normalised(dataset: Dataset, images_px: FloatArray) -> FloatArray:
    return dataset.normalisation.apply(images_px).reshape(len(images_px), -1)


def _standard(poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and standard deviation (3,) of poses; an output that never changes keeps its unit."""
    sd = poses.std(axis=0)
    return poses.mean(axis=0), np.where(sd > 1e-9, sd, 1.0)
