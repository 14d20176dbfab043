"""Compare planned calibration presses with the same number at random: predicted posterior of simulated units.

    python benchmarks/planned_presses.py TWIN.h5 [--markers 61] [--units 20] [--presses 5] [--draws 5]

Planned presses are those of `palpate recording take --next`: the first by `calibration_pose`, then the best one of
`rank_next_presses`. Random presses are uniform in the disc of tilts; `shallow` ones also end at a random depth. For
`least sd`, each press has the least sum of log standard deviations of all candidates. Images per press, noise and
robot are equal. Prints ratios to random presses over units: of the posterior standard deviations of unit and mounting
(geometric mean), and of the RMSE of rx and ry by the uncertainty of the unit.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from palpate.calibration import (
    AccuracySpec,
    CalibrationPress,
    ToleranceSpec,
    calibration_pose,
    rank_next_presses,
    sample_deviation,
)
from palpate.calibration.mounting import Mounting, prior_mounting
from palpate.calibration.next_press import NextPress
from palpate.calibration.predict_posterior import predict_posterior
from palpate.calibration.unit_model import UnitModel
from palpate.core import FloatArray
from palpate.design import Design, DomeSpec, MarkerSpec, rotation_vector
from palpate.sensor import Unit, open_sensor
from palpate.simulation import DEGRADED, SimulatedUnit
from palpate.surrogate import Twin, read_twin

IMAGES, MIN_DEPTH, INVERSE_FRICTION = 6, 1.5, 1.0
Place = tuple[float, float, float]
"""Tilt and azimuth of a press, degrees, and its last depth as a share of the maximum."""


def after(model: UnitModel, spec: AccuracySpec, places: Sequence[Place]) -> Mounting:
    """Mounting with the joint covariance of unit and mounting after presses."""
    before, presses = prior_mounting(model.posterior, model.tolerance), []
    for tilt, azimuth, share in places:
        deepest = model.marker_twin.twin.max_depth(tilt, INVERSE_FRICTION)
        depths = np.linspace(MIN_DEPTH, MIN_DEPTH + share * (deepest - MIN_DEPTH), IMAGES)
        poses = np.array([[*rotation_vector(tilt, np.radians(azimuth)), depth] for depth in depths])
        pixels = np.array([model.predict(pose, INVERSE_FRICTION, unit=False).pixels for pose in poses])
        presses.append((CalibrationPress(poses, pixels), INVERSE_FRICTION))
    found = predict_posterior(model, before, presses, spec.noise_px, spec.robot)
    return replace(before, covariance=found.covariance)


def spread(mounting: Mounting) -> FloatArray:
    """Posterior standard deviations (15,) of unit and mounting."""
    return np.asarray(np.sqrt(np.diag(mounting.covariance)), float)


def plan(
    model: UnitModel, spec: AccuracySpec, count: int, choose: Callable[[Mounting, list[Place]], NextPress]
) -> list[Place]:
    """Places of presses, the first of them by `calibration_pose`."""
    places: list[Place] = [(*calibration_pose(0, spec.max_tilt_deg), 1.0)]
    while len(places) < count:
        best = choose(after(model, spec, places), places)
        places.append((best.tilt_deg, best.azimuth_deg, 1.0))
    return places


def compare(twin: Twin, design: Design, number: int, count: int, draws: int) -> FloatArray:
    """Ratios (3, 2) as printed, of standard deviations and RMSE, for one unit."""
    spec = AccuracySpec(max_tilt_deg=float(twin.tilts_deg[-1]), min_depth=MIN_DEPTH)
    simulated = SimulatedUnit(design, sample_deviation(ToleranceSpec(), 0, number), DEGRADED)
    fitter = open_sensor([simulated.render_rest()], Unit(design), twin).estimator.twin_fit
    assert fitter is not None
    model = fitter.model

    def by_error(mounting: Mounting, places: list[Place]) -> NextPress:
        ranked, taken = rank_next_presses(model, mounting, INVERSE_FRICTION, spec)[1], [place[:2] for place in places]
        return next(press for press in ranked if press[:2] not in taken)

    def by_spread(mounting: Mounting, places: list[Place]) -> NextPress:
        ranked = rank_next_presses(model, mounting, INVERSE_FRICTION, spec)[1]
        return min(ranked, key=lambda one: np.log(spread(after(model, spec, [*places, (*one[:2], 1.0)]))).sum())

    def figures(places: Sequence[Place]) -> FloatArray:
        mounting = after(model, spec, places)
        rmse = rank_next_presses(model, mounting, INVERSE_FRICTION, spec)[0]
        return np.log(np.append(spread(mounting), rmse))

    rng = np.random.default_rng(number)
    tilts = spec.max_tilt_deg * np.sqrt(rng.uniform(size=(draws, count)))
    turns, shares = rng.uniform(0.0, 360.0, (draws, count)), rng.uniform(size=(draws, count))
    drawn = [list(zip(*each, strict=True)) for each in zip(tilts, turns, shares, strict=True)]
    deep = np.mean([figures([(tilt, turn, 1.0) for tilt, turn, _ in each]) for each in drawn], axis=0)
    shallow = np.mean([figures(each) for each in drawn], axis=0)
    planned, least = (figures(plan(model, spec, count, choose)) for choose in (by_error, by_spread))
    ratios = np.exp([planned - deep, least - deep, planned - shallow])
    return np.stack([np.exp(np.log(ratios[:, :-1]).mean(axis=1)), ratios[:, -1]], axis=1)


def main() -> None:
    """Print the ratios of all units: mean, minimum and maximum."""
    parser = argparse.ArgumentParser()
    parser.add_argument("twin", type=Path)
    for flag, default in (("markers", 61), ("units", 20), ("presses", 5), ("draws", 5)):
        parser.add_argument(f"--{flag}", type=int, default=default)
    words = parser.parse_args()
    design = Design(DomeSpec(), MarkerSpec(count=words.markers))
    twin, units = read_twin(words.twin), range(1, words.units + 1)
    found = np.array([compare(twin, design, unit, words.presses, words.draws) for unit in units])
    for k, label in enumerate(("planned / random", "least sd / random", "planned / shallow random")):
        for column, figure in enumerate(("standard deviations", "RMSE")):
            values = found[:, k, column]
            print(f"{label}, {figure}: {values.mean():.3f} ({values.min():.3f} to {values.max():.3f})", flush=True)


if __name__ == "__main__":
    main()
