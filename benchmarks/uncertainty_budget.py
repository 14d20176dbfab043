"""Coverage of the expanded uncertainty on simulated units, and recovery of variances by the gauge study.

    python benchmarks/uncertainty_budget.py [--units 500] [--studies 400] [--out docs/results/sensor/uncertainty.csv]

**Coverage.** Units within the tolerances have rest images and presses with noise, misprinted and missing markers,
their own camera, lens, thickness, friction and seating, and a temperature that has changed since the rest image. The
images of a press come from the twin of the estimator (same mesh), or from a twin on a finer mesh. Each unit is read
by the nonlinear chain: `infer_from_rest`, `build_unit_model` and `PoseFitter`. The budget is linear. It sees the
tolerances and, for that of each unit, its rest image. It knows the finer mesh only by the error that its presses show
(`measure_twin_error`); on the same mesh, it has no error of the twin.

`true` is the RMSE and `estimate` u. `coverage` is the share of readings within U = 2 u of the working range (rx, ry,
total angle), or within the 95.45 % radius (angle between normals); `low` and `high` are the ends of its 95 %
bootstrap interval over units. A control halves all tolerances in the budget; its coverage must fail.

**Gauge study.** Readings with known variances are analysed by `study_repeatability`. `estimate` is the mean over
studies of the component, `true` its value, `coverage` the share of 95 % intervals that contain it. REML of the first
study by Fisher scoring (in the column `true`) is the second way.
"""

import argparse
import csv
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

sys.path.append(str(Path(__file__).parents[1] / "tests"))

from palpate.calibration import (
    CONTACT_STATE,
    UNIT_PARAMETERS,
    AccuracySpec,
    PoseFitter,
    ToleranceSpec,
    UncertaintyBudget,
    UnitModel,
    ValidationPresses,
    build_unit_model,
    infer_from_rest,
    sample_deviation,
)
from palpate.calibration.mounting import MOUNTING_PARAMETERS, Mounting
from palpate.calibration.predict_accuracy import sample_working_range
from palpate.calibration.uncertainty import UncertaintyComponent
from palpate.camera import project_markers
from palpate.core import FloatArray, IntArray, generator
from palpate.core.state import State
from palpate.design import Design, build_skin
from palpate.fea import Press
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import ReferenceSpec
from palpate.sensor.gauge_study import TERMS, study_repeatability
from palpate.simulation import SimulatedUnit, TwinBackend
from palpate.surrogate import Twin
from presses import build_twin, solve_press
from small_chain import DOME, MARKERS, MATERIAL, small_twin, twin_presses

FINER_CELLS = 13
IMAGES, OWN_POSES = 20, 40
"""Images of a unit, and poses of its own budget."""
TWIN_LINE = "error of the twin"
SCALED = tuple(name for name in ToleranceSpec.model_fields if name not in ("friction_min", "friction_max", "missing"))
SD_DEG = {
    "part": 4.0,
    "operator": 0.03,
    "day": 0.03,
    "part × operator": 0.02,
    "mounting": 0.05,
    "repeatability": 0.03,
}
"""Standard deviations of simulated gauge studies, degrees."""
SIZES = {"part": 6, "operator": 6, "day": 5, "mounting": 2, "repeat": 2}
STEPS = 12
"""Levels of simulated gauge studies."""
COLUMNS = ("case", "quantity", "count", "true", "estimate", "limit_deg", "coverage", "low", "high")


def finer_presses() -> list[Press]:
    """Presses of the twin, on a finer mesh."""
    mesh = mesh_skin(build_skin(DOME), MeshSpec(cells=FINER_CELLS))
    return [solve_press(mesh, MATERIAL, press.obstacle, press.solver) for press in twin_presses()]


def budget_limits(model: UnitModel, spec: AccuracySpec, error: UncertaintyComponent | None) -> FloatArray:
    """2 u of rx, ry and the total angle, and radius of the angle between normals (4,), with an error of the twin."""
    found = UncertaintyBudget.of_unit(model, None, spec, ReferenceSpec().thermal)
    kept = [line for line in found.components if line.name != TWIN_LINE] + ([error] if error else [])
    known = replace(found, components=tuple(kept))
    ratio = float(known.combined_deg[-1] / found.combined_deg[-1])
    return np.append(2.0 * known.combined_deg, ratio * found.normal_deg)


def nominal_model(twin: Twin, design: Design, tolerance: ToleranceSpec, spec: AccuracySpec) -> UnitModel:
    """Model of the nominal unit after its rest image."""
    rest = design.camera.project(design.layout.positions)
    belief = infer_from_rest(twin, design.layout, design.camera_spec, rest, tolerance, spec.noise_px)
    belief = replace(belief, mean=State.zeros(UNIT_PARAMETERS))
    return build_unit_model(twin, design.layout, belief, tolerance)


def twin_error(model: UnitModel, spec: AccuracySpec, finer: list[Press]) -> UncertaintyComponent | None:
    """Line of the twin's error, measured by the finer presses; `None` without any."""
    if not finer:
        return None
    contacts = {press.obstacle.friction for press in finer}
    checks = [ValidationPresses((), [press for press in finer if press.obstacle.friction == mu]) for mu in contacts]
    found = UncertaintyBudget.of_unit(model, None, spec, None, checks)
    return next(line for line in found.components if line.name == TWIN_LINE)


def read_unit(
    number: int, twin: Twin, truth: Twin, design: Design, spec: AccuracySpec
) -> tuple[FloatArray, FloatArray, UnitModel]:
    """True and estimated rx, ry (n, 2) of one unit, on the robot's scale, degrees, and its model."""
    tolerance, rng = ToleranceSpec(), generator(spec.seed, "coverage", number)
    deviation = sample_deviation(tolerance, spec.seed, number)
    unit = SimulatedUnit(design, deviation)
    backend = TwinBackend(unit, truth)

    def see(edges: FloatArray, kelvin: float) -> FloatArray:
        thermal = ReferenceSpec()
        warm = replace(
            deviation,
            focal=deviation.focal + kelvin * thermal.focal_per_k,
            distance=deviation.distance + kelvin * thermal.holder_per_k * design.camera_spec.distance,
        )
        centres = project_markers(warm.built(design).camera, edges[:-1] * (1.0 + kelvin * thermal.skin_per_k)).centres
        pixels = np.full((len(design.layout), 2), np.nan)
        pixels[unit.printed] = centres + spec.noise_px * rng.standard_normal(centres.shape)
        return pixels

    rest = see(unit.edges, 0.0)
    belief = infer_from_rest(twin, design.layout, design.camera_spec, rest, tolerance, spec.noise_px)
    fitter = PoseFitter(build_unit_model(twin, design.layout, belief, tolerance), spec.noise_px)
    seated = State(MOUNTING_PARAMETERS, np.array([getattr(deviation, name) for name in MOUNTING_PARAMETERS]))
    mounting = Mounting(seated, np.eye(len(UNIT_PARAMETERS) + len(MOUNTING_PARAMETERS)))
    kelvin = ReferenceSpec().temperature_change * float(rng.uniform(-1.0, 1.0))
    true, found = [], []
    for pose, _ in sample_working_range(truth, replace(spec, poses=IMAGES), tolerance, rng):
        contact = State.zeros(CONTACT_STATE).replace(
            rx_deg=pose[0], ry_deg=pose[1], depth_mm=pose[2], inverse_friction=1.0 / deviation.friction
        )
        true.append(mounting.to_robot(pose)[:2])
        seen = see(backend.edges(contact), kelvin)
        fitter.fit(seen)  # the images of a press follow each other, so that a fit starts near
        found.append(fitter.fit(seen).pose[:2])
    return np.array(true), np.array(found), fitter.model


def angle_errors(true: FloatArray, found: FloatArray) -> FloatArray:
    """Errors (..., 4) of rx, ry and the total angle, and angle between the wall normals, degrees."""
    total = np.linalg.norm(found, axis=-1) - np.linalg.norm(true, axis=-1)
    first, second = (
        Rotation.from_rotvec(np.pad(each.reshape(-1, 2), ((0, 0), (0, 1))), degrees=True).apply([0.0, 0.0, 1.0])
        for each in (true, found)
    )
    apart = np.degrees(np.linalg.norm(np.cross(first, second), axis=1)).reshape(total.shape)
    return np.concatenate([found - true, total[..., None], apart[..., None]], axis=-1)


def coverage_rows(units: int, spec: AccuracySpec, finer: list[Press]) -> list[dict[str, object]]:
    """Coverage over simulated units."""
    design, twin = Design(DOME, MARKERS, material=MATERIAL), small_twin()
    truth = build_twin(finer) if finer else twin
    read = [read_unit(number, twin, truth, design, spec) for number in range(1, units + 1)]
    errors = angle_errors(np.array([each[0] for each in read]), np.array([each[1] for each in read]))
    error = twin_error(nominal_model(twin, design, ToleranceSpec(), spec), spec, finer)
    own = replace(spec, poses=OWN_POSES, units=OWN_POSES)
    cases = {"budget of each unit": np.array([budget_limits(each[2], own, error) for each in read])}
    for name, share in (("budget of the design", 1.0), ("control, half the tolerances", 0.5)):
        scaled = {field: share * getattr(ToleranceSpec(), field) for field in SCALED}
        model = nominal_model(twin, design, ToleranceSpec().model_copy(update=scaled), spec)
        cases[name] = np.tile(budget_limits(model, spec, error), (units, 1))
    rows, rms = [], np.sqrt((errors**2).mean(axis=(0, 1)))
    for name, limits in cases.items():
        inside = (np.abs(errors) <= limits[:, None]).mean(axis=1)
        drawn = generator(0, "bootstrap").integers(0, units, (2000, units))
        ends = np.quantile(inside[drawn].mean(axis=1), [0.025, 0.975], axis=0)
        limit = np.sqrt((limits**2).mean(axis=0))
        for k, measurand in enumerate(("rx", "ry", "total angle", "angle between normals")):
            rows.append(
                {
                    "case": f"coverage, {name}, {'finer mesh' if finer else 'same mesh'}",
                    "quantity": measurand,
                    "count": units,
                    "true": round(float(rms[k]), 4),
                    "estimate": round(float(limit[k] / 2.0), 4) if k < 3 else "",
                    "limit_deg": round(float(limit[k]), 4),
                    "coverage": round(float(inside[:, k].mean()), 4),
                    "low": round(float(ends[0, k]), 4),
                    "high": round(float(ends[1, k]), 4),
                }
            )
    return rows


def draw_study(seed: int) -> tuple[dict[str, FloatArray], dict[str, IntArray]]:
    """Readings (n,) with the variances of `SD_DEG`, and the levels of the factors."""
    rng = generator(seed, "gauge study")
    part, operator, day, mounting, _ = (each.ravel() for each in np.indices(tuple(SIZES.values())))
    levels = {"part": part, "operator": operator, "day": day, "mounting": mounting}
    values = SD_DEG["repeatability"] * rng.standard_normal(len(part))
    for term, factors in TERMS.items():
        labels = np.unique(np.column_stack([levels[name] for name in factors]), axis=0, return_inverse=True)[
            1
        ].ravel()
        values += SD_DEG[term] * rng.standard_normal(labels.max() + 1)[labels]
    return {"rx": values}, levels


def fit_reml(value: FloatArray, levels: dict[str, IntArray]) -> FloatArray:
    """Variance components (6,) that maximise the restricted likelihood of readings (n,)."""
    designs = []
    for factors in TERMS.values():
        labels = np.unique(np.column_stack([levels[name] for name in factors]), axis=0, return_inverse=True)[
            1
        ].ravel()
        designs.append(np.eye(labels.max() + 1)[labels])
    products, one = [*(each @ each.T for each in designs), np.eye(len(value))], np.ones(len(value))
    found = np.array(list(SD_DEG.values())) ** 2
    for _ in range(STEPS):  # Fisher scoring
        inverse = np.linalg.inv(np.tensordot(found, products, 1))
        flat = inverse @ one
        inverse -= np.outer(flat, flat) / (one @ flat)
        parts = [inverse @ product for product in products]
        information = np.array([[np.sum(first * second.T) for second in parts] for first in parts])
        score = [value @ part @ (inverse @ value) - part.trace() for part in parts]
        found = found + np.linalg.solve(information, score)
    return found


def gauge_rows(studies: int) -> list[dict[str, object]]:
    """Mean and coverage of the variance components of simulated studies, and REML of the first."""
    found = [study_repeatability(*draw_study(seed)).components["rx"] for seed in range(studies)]
    values, levels = draw_study(0)
    second = fit_reml(values["rx"], levels)
    rows = []
    for k, (term, sd) in enumerate(SD_DEG.items()):
        own = [each[k] for each in found]
        inside = np.mean([each.low <= sd**2 <= each.high for each in own])
        rows.append(
            {
                "case": "gauge study, mean of studies",
                "quantity": term,
                "count": studies,
                "true": f"{sd**2:.3e}",
                "estimate": f"{np.mean([each.variance for each in own]):.3e}",
                "coverage": round(float(inside), 3),
            }
        )
        rows.append(
            {
                "case": "gauge study, first: REML and ANOVA",
                "quantity": term,
                "count": 1,
                "true": f"{second[k]:.4e}",
                "estimate": f"{own[0].variance:.4e}",
                "low": f"{own[0].low:.2e}",
                "high": f"{own[0].high:.2e}",
            }
        )
    return rows


def main() -> None:
    """Measure and write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--units", type=int, default=500)
    parser.add_argument("--studies", type=int, default=400)
    parser.add_argument("--out", type=Path, default=Path("docs/results/sensor/uncertainty.csv"))
    asked, spec = parser.parse_args(), AccuracySpec(poses=200)
    rows = gauge_rows(asked.studies)
    for finer in ([], finer_presses()):
        rows += coverage_rows(asked.units, spec, finer)
    with asked.out.open("w", newline="") as file:
        file.write(f"# python benchmarks/uncertainty_budget.py --units {asked.units} --studies {asked.studies}\n")
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    for row in rows:
        print(row)


if __name__ == "__main__":
    main()
