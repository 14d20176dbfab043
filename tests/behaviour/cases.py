"""Reference cases of every stage: small computations whose results `palpate.core.behaviour` turns into stamps.

Each function of `CASES` returns case → name → numbers. Together they run through branches, contact laws, skins,
obstacles and lenses, so that a change of a stage changes a number here.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from palpate_benchmark import PRESETS, make_benchmark, read_set
from palpate_benchmark.simulate_unit import simulate_unit
from palpate_benchmark.spec import TINY_BASELINES
from palpate_benchmark.trained_baselines import predict_by_markers

from drawn_tactip import DrawnSensor, draw_motions, draw_recording
from palpate.calibration import AccuracySpec, ToleranceSpec, predict_accuracy, sample_deviation
from palpate.camera import CameraSpec, build_camera
from palpate.core import ArtefactStore
from palpate.core.named_arrays import read_arrays
from palpate.core.run import Progress
from palpate.datasets import DatasetSpec, PerturbedPresses, RandomisationSpec, generate_dataset, read_recording
from palpate.design import MarkerSpec, build_skin, place_markers, skin_from_data
from palpate.fea import BallSpec, Branch, CylinderSpec, Press, WallSpec, read_obstacle
from palpate.fea.route import RouteSpec
from palpate.learn import (
    RecordingSpec,
    calibrate_interval,
    compute_error_bounds,
    evaluate,
    fit_ridge,
    measure_coverage,
    open_predictor,
    read_estimator,
    train_force_output,
    train_on_recording,
    write_estimator,
)
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.optimise import RequirementsSpec
from palpate.optimise.evaluate_skin import evaluate_skin
from palpate.optimise.skin_evaluation import SkinEvaluation
from palpate.simulation import run_unit_trial
from palpate.simulation.trial import COLUMNS
from palpate.surrogate import TWIN_DERIVATIVES, MarkerTwin, build_field
from palpate.vision import prepare_detector
from presses import build_twin, run_tiny_study, solve_press, stored_folder
from small_chain import TWIN_CELLS, TWIN_DEPTH, small_bench, small_twin, write_small_twin

Results = dict[str, dict[str, Any]]

DOME = {"kind": "dome", "height": 20.0, "thickness": 2.0}
SKINS = {
    "dome": DOME,
    "thin": {"kind": "dome", "height": 20.0, "thickness": 1.0},
    "low": {"kind": "dome", "height": 10.0, "thickness": 2.0},
    "ellipsoid": {"kind": "ellipsoid", "height": 20.0, "thickness": 2.0},
    "cone": {
        "kind": "cone",
        "height": 3.5,
        "thickness": 0.5,
        "base_radius": 12.9,
        "flat_radius": 10,
        "edge_radius": 2,
    },
    "pinned": {"kind": "pinned", "height": 20.0, "thickness": 2.0, "pin": 2.0},
    "pad": {
        "kind": "pad",
        "height": 3.5,
        "thickness": 0.5,
        "base_radius": 10.375,
        "stretch": 1.217,
        "squareness": 6.0,
        "flat_radius": 7.5,
    },
    "barrel": {"kind": "barrel"},
}
SILICONE, MARKERS = "zaid_2024_ecoflex_00_30", MarkerSpec(count=37)


def skin_of(name: str) -> Any:
    return build_skin(skin_from_data(SKINS[name]))


@cache
def solve(name: str, obstacle: Any, cells: int | None = 6, **options: Any) -> Press:
    branch = options.pop("branch", Branch.FLAT)
    material, solver = get_material(SILICONE), SolverSpec(derivatives=options.pop("derivatives", ()))
    if options.get("filled"):
        material = replace(material, gel=get_material("neo-hooke:0.005"))
    return solve_press(mesh_skin(skin_of(name), MeshSpec(cells=cells, **options)), material, obstacle, solver, branch)


def summarise(found: Press) -> dict[str, Any]:
    """Numbers of a press in which every field takes part."""
    moved = found.displacement
    return {
        "depth": found.depth,
        "force": found.force,
        "moved": np.linalg.norm(moved, axis=(1, 2)),
        "apex": moved[:, found.mesh.pole_inner],
        "energy": found.energy,
        "contact_energy": found.contact_energy,
        "dissipation": found.dissipation,
        "work": found.work,
        "stress": found.peak_stress,
        "area": found.contact_area,
        "gap": found.apex_gap,
        "inverted": [str(branch) == "inverted" for branch in found.branch],
        "unknowns": found.unknowns,
        **{
            f"by {name}": [float(np.linalg.norm(one.displacement)), float(np.linalg.norm(one.force))]
            for name, one in found.derivatives.items()
        },
    }


def presses() -> Results:
    wall = {"depth": 4.0, "depth_step": 1.0}
    found = {
        "no slip": solve("dome", WallSpec(tilt_deg=6, contact="no-slip", **wall), derivatives=TWIN_DERIVATIVES),
        "frictionless": solve("dome", WallSpec(tilt_deg=6, contact="frictionless", **wall)),
        "friction": solve("dome", WallSpec(tilt_deg=9, contact=0.6, azimuth_deg=40, unload=True, **wall)),
        "snap": solve("thin", WallSpec(depth=8, depth_step=2.0)),
        "inverted": solve("thin", WallSpec(depth=8, depth_step=2.0), branch=Branch.INVERTED),
        "low": solve("low", WallSpec(tilt_deg=3, depth=3, depth_step=1.0)),
        "ellipsoid": solve(
            "ellipsoid", WallSpec(tilt_deg=4, lateral_rate=0.1, twist_rate_deg=1.0, curvature=5.0, **wall), whole=True
        ),
        "ball": solve("dome", BallSpec(radius=6, offset=3, **wall)),
        "cylinder": solve("dome", CylinderSpec(**wall)),
        "edge": solve("dome", read_obstacle("edge", WallSpec(depth=2, depth_step=1.0))),
        "route": solve("dome", RouteSpec(waypoints=((2.0, 0.3), (2.0, 0.3, 0.2, 2)), depth_step=0.5), whole=True),
        "pins": solve("pinned", WallSpec(tilt_deg=4, depth=2, depth_step=1.0)),
        "pad": solve("pad", WallSpec(tilt_deg=2, azimuth_deg=30, depth=0.4, depth_step=0.2), cells=4, whole=True),
        "barrel": solve(
            "barrel",
            read_obstacle("side_wall:tilt_deg=91", WallSpec(depth=2, depth_step=1.0, contact="frictionless")),
            cells=10,
            core=2,
        ),
        "gel": solve("cone", WallSpec(tilt_deg=1, depth=0.4, depth_step=0.2), core=1, filled=True),
    }
    meshes = {name: mesh_skin(skin_of(name), MeshSpec()) for name in SKINS}
    sizes = {
        name: [len(mesh.nodes), len(mesh.cells), float(np.abs(mesh.nodes).sum())] for name, mesh in meshes.items()
    }
    return {name: summarise(one) for name, one in found.items()} | {"default mesh": sizes}


def small_presses(contact: str | float = "no-slip", **update: Any) -> list[Press]:
    return [
        solve("dome", WallSpec(tilt_deg=tilt, depth=5.0, depth_step=1.0, contact=contact), **update)
        for tilt in (0.0, 4.0, 8.0)
    ]


@cache
def small_dataset(forces: bool = False) -> Any:
    spec = DatasetSpec(n_presses=100, max_tilt_deg=8.0, jitter_px=0.2)
    return generate_dataset(
        small_presses(), place_markers(skin_of("dome"), MARKERS), build_camera(), spec, forces=forces
    )


def datasets() -> Results:
    found = small_dataset()
    camera = build_camera(CameraSpec(lens="kannala-brandt", distance=30))
    unit = generate_dataset(
        small_presses(),
        place_markers(skin_of("dome"), MARKERS),
        camera,
        DatasetSpec(
            n_presses=20, max_tilt_deg=8.0, randomise=RandomisationSpec(dot=0.05, camera_offset=0.1, focal=0.01)
        ),
    )
    dome, camera = place_markers(skin_of("dome"), MARKERS), build_camera()
    balls = [BallSpec(radius=6, offset=offset, depth=3, depth_step=1.0) for offset in (0.0, 1.5, 3.0)]
    offset = generate_dataset([solve("dome", ball) for ball in balls], dome, camera, DatasetSpec(n_presses=20))
    other = PerturbedPresses(frictions=(small_presses(0.6),))
    varied = DatasetSpec(n_presses=20, max_tilt_deg=8.0, randomise=RandomisationSpec(frictions=(0.6,)))
    turned = [
        solve(
            "pad",
            WallSpec(tilt_deg=tilt, azimuth_deg=azimuth, depth=0.4, depth_step=0.2),
            cells=4,
            core=1,
            filled=True,
            **({"whole": True} if azimuth else {}),
        )
        for tilt, azimuth in ((0.0, 0.0), *((tilt, azimuth) for tilt in (1.0, 2.0) for azimuth in (0.0, 45.0, 90.0)))
    ]
    layout = place_markers(skin_of("pad"), MarkerSpec(ring_diameters=(4.5, 9.0), diameter=0.6))
    pad = generate_dataset(turned, layout, camera, DatasetSpec(n_presses=20, max_tilt_deg=2.0, dropped_images=0))
    made = {"nominal": found, "randomised": unit, "ball": offset, "pad": pad}
    made["friction"] = generate_dataset(small_presses(), dome, camera, varied, other)
    return {
        name: {
            "images": one.images_px[:: max(len(one.poses) // 5, 1)],
            "poses": one.poses[::10],
            "held out": int(one.validation.sum()),
            "press": one.press[::10],
        }
        for name, one in made.items()
    }


def error_bounds() -> Results:
    field = build_field(small_presses(), place_markers(skin_of("dome"), MARKERS))
    found = compute_error_bounds(field, build_camera(), small_dataset().spec, 0)
    return {f"{one.depth_mm:g} mm": asdict(one) for one in found}


@cache
def study_results() -> Path:
    return run_tiny_study(Path(tempfile.mkdtemp(prefix="palpate-behaviour-")))


def estimators() -> Results:
    results: Results = {}
    for path in sorted((study_results() / "store" / "estimator").rglob("*.onnx")):
        found = open_predictor(path)
        rest = read_estimator(path).rest_px
        moved = rest[None] + np.linspace(-3, 3, 5)[:, None, None] * np.array([1.0, 0.5])
        told = found.predict(moved)
        results[f"{len(rest)} markers"] = {
            "poses": told.pose,
            "half_width": told.half_width,
            "out_of_distribution": told.out_of_distribution,
        }
    return results


def evaluations() -> Results:
    dataset = small_dataset()
    ridge = fit_ridge(dataset)
    measured = {"clean": evaluate(ridge, dataset, None), "jittered": evaluate(ridge, dataset, 0)}
    coverage = measure_coverage(calibrate_interval(ridge, dataset, 0), dataset, 0)
    assert coverage is not None
    return {
        name: {axis: [error.rmse, error.max] for axis, error in one.by_axis.items()} for name, one in measured.items()
    } | {"coverage": asdict(coverage)}


def force_estimators() -> Results:
    dataset = small_dataset(forces=True)
    with tempfile.TemporaryDirectory() as name:
        pose, force = Path(name) / "pose.onnx", Path(name) / "force.onnx"
        write_estimator(pose, fit_ridge(dataset))
        train_force_output(pose, dataset, force)
        return {"ridge": {"force": open_predictor(force).predict(dataset.images_px[::50]).forces}}


def twins() -> Results:
    printed = small_twin().with_markers(place_markers(skin_of("dome"), MARKERS).positions)
    results: Results = {}
    for name, touch in {"straight": (0.0, 0.0, 2.0), "tilted": (5.0, -2.0, 3.3), "shallow": (1.0, 7.0, 0.7)}.items():
        moved = printed.evaluate(np.array(touch), 0.7, 0.02)
        results[name] = {"positions": moved.positions, "by": moved.jacobian.values, "force": moved.force}
    moved = half_size_twin().evaluate(np.array((3.0, -2.0, 1.1)), 0.0, 0.01)
    results["half the size"] = {"positions": moved.positions, "by": moved.jacobian.values, "force": moved.force}
    return results


def half_size_twin() -> MarkerTwin:
    """Twin of a dome of half the size, whose accuracy scales with it."""
    skin = build_skin(skin_from_data(DOME | {"height": 10.0, "base_radius": 10.0, "thickness": 1.0}))
    walls = [WallSpec(tilt_deg=tilt, contact="frictionless", depth=1.5, depth_step=0.3) for tilt in (0.0, 4.0, 8.0)]
    mesh, solver = mesh_skin(skin, MeshSpec(cells=6)), SolverSpec(derivatives=TWIN_DERIVATIVES)
    twin = build_twin([solve_press(mesh, get_material(SILICONE), wall, solver) for wall in walls])
    return twin.with_markers(place_markers(skin, MarkerSpec(ring_diameters=(5.0, 10.0))).positions)


def accuracies() -> Results:
    layout, camera = place_markers(skin_of("dome"), MARKERS), build_camera()
    found = {
        known: predict_accuracy(
            small_twin(),
            layout,
            camera,
            ToleranceSpec(),
            AccuracySpec(30, 20, max_tilt_deg=9.0, calibration_presses=known),
        )
        for known in (0, 4)
    }
    return {f"{known} known": asdict(figure) for known, figure in found.items()}


def unit_trials() -> Results:
    with tempfile.TemporaryDirectory() as name:
        small = {"units": 1, "tilts": 1, "azimuths": 2, "depth": TWIN_DEPTH, "cells": TWIN_CELLS}
        bench = small_bench(Path(name), write_small_twin(Path(name) / "twin.h5"), **small)
        found = run_unit_trial(bench, sample_deviation(bench.spec.tolerance, 3, 1))
    return {"twin": {name: found.column(name) for name in COLUMNS if name != "latency_ms"}}


def skin_evaluations() -> Results:
    spec = RequirementsSpec(name="behaviour", markers=19, depth=4.0, max_tilt_deg=8.0)
    skin = skin_from_data(SKINS["dome"])
    found = evaluate_skin(small_twin(), SkinEvaluation(skin, SILICONE, 4.0, 0.3, None, ()), spec)
    return {
        f"option {number}": {
            "rings": option.markers.ring_diameters or (),
            "rmse": option.accuracy.rmse_deg,
            "worst": option.accuracy.p95_deg,
        }
        for number, option in enumerate(found.options)
    }


def benchmark_units() -> Results:
    spec = PRESETS["tiny"]
    found = simulate_unit(spec, spec.designs[0], 1, small_twin())
    return {
        "unit 1": {
            "markers": found.markers_px[::5],
            "labels": found.labels,
            "images": [float(image.mean()) for image in found.pictures],
        }
    }


def baselines() -> Results:
    spec = PRESETS["tiny"]
    folder = stored_folder("benchmark", [spec.model_dump_json()], lambda made: make_benchmark(spec, made, workers=1))
    found = read_set(folder / "set")
    predicted = predict_by_markers("ridge", found, spec.designs[0], TINY_BASELINES)
    return {"ridge": dict(predicted.values)}


@cache
def recorded(estimators: str = "ridge", **spec: int) -> tuple[Path, Any]:
    folder = Path(tempfile.mkdtemp(prefix="palpate-behaviour-"))
    draw_recording(folder, draw_motions(60, 1, shear=2.0), DrawnSensor(rings=3))
    spec = RecordingSpec(estimators=estimators, threads=1, **spec)
    found = train_on_recording(read_recording(folder), spec, ArtefactStore(folder / "store"), Progress())
    return folder / "store", found


def detections() -> Results:
    image = np.zeros((420, 420), np.uint8)
    turns = np.concatenate([np.arange(6 * k) * np.pi / (3 * k) for k in range(1, 11)])
    away = np.repeat(18.3 * np.arange(1, 11), 6 * np.arange(1, 11))
    glints = np.array([0.2, 0.9, 2.1, 3.3, 4.4, 5.6])
    turns, away = np.r_[turns, glints], np.r_[away, np.full(6, 206.0)]
    for x, y in 210.0 + away[:, None] * np.c_[np.cos(turns), np.sin(turns)]:
        cv2.circle(image, (round(x), round(y)), 5, 255, -1)
    rim = prepare_detector(image).find(image)
    return {"drawn recording": _arrays_of("sight"), "rim": {"positions": rim.positions_px[::20], "count": [len(rim)]}}


def correspondences() -> Results:
    return {"drawn recording": _arrays_of("assigned")}


def recorded_estimators() -> Results:
    results: Results = {}
    for name, found in {"ridge": recorded()[1], "network": recorded("picture", picture_px=32, epochs=2)[1]}.items():
        read = [found.model.read(image)[0] for image in found.seen.recording.images.read(range(0, 60, 20))]
        results[name] = {
            "poses": found.estimates[::5],
            "rmse": [error.rmse for error in found.scores[0].errors],
            "read": [one.pose[0] for one in read],
            "half_width": [one.half_width[0] for one in read],
            "every": [[error.rmse for error in one.errors] for one in sorted(found.scores, key=lambda one: one.name)],
        }
    return results


def _arrays_of(kind: str) -> dict[str, Any]:
    """Numbers of every array of the artefacts of a kind: size, number of finite values, mean, mean square."""
    results: dict[str, Any] = {}
    for number, path in enumerate(sorted((recorded()[0] / kind).rglob("*.h5"))):
        for name, values in read_arrays(path).items():
            if np.issubdtype(np.asarray(values).dtype, np.number):
                finite = np.asarray(values, float)[np.isfinite(np.asarray(values, float))]
                summary = [finite.mean(), (finite**2).mean()] if finite.size else []
                results[f"{number} {name}"] = [np.size(values), finite.size, *map(float, summary)]
    return results


CASES: dict[str, Callable[[], Results]] = {
    "press": presses,
    "dataset": datasets,
    "error_bound": error_bounds,
    "estimator": estimators,
    "test_errors": evaluations,
    "force_estimator": force_estimators,
    "twin": twins,
    "accuracy": accuracies,
    "unit_trial": unit_trials,
    "skin_evaluation": skin_evaluations,
    "benchmark_unit": benchmark_units,
    "baseline": baselines,
    "detections": detections,
    "correspondence": correspondences,
    "recorded_estimator": recorded_estimators,
}
"""Stage → its reference cases."""
ROUNDING: dict[str, float] = {
    "estimator": 0.02,
    "force_estimator": 0.02,
    "recorded_estimator, network": 0.02,
    "baseline": 1e-4,
}
"""Stage, or stage and case → share of a result's size by which results differ between processors.

Trained networks differ by 0.02. The files of the benchmark set store pixels as 32 bit numbers: their last digit moves
a half-width by 2e-5.
"""
