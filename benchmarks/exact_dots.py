"""Read units of a search's winner and rival by exact dots, without an image: what the twin itself is off.

    python benchmarks/exact_dots.py FOLDER [UNITS] [known-robot]

FOLDER is that of a search whose front was reported, with a rival and its twin. Units, known presses, presses and
directions are those of the proof; dots are the centres of their projected traces. `known-robot` lets the robot know
its poses in the known presses. Presses that the proof made are found in the folder's store, others are made there.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from palpate.calibration import (
    CalibrationPress,
    Deviation,
    PoseFitter,
    build_unit_model,
    identify,
    infer_from_rest,
    sample_deviation,
)
from palpate.calibration.noise import NOISE_PX
from palpate.camera import project_markers
from palpate.core import ArtefactStore, FloatArray, generator
from palpate.design import Design, MarkerSpec, skin_from_data
from palpate.fea import Press
from palpate.material import get_material
from palpate.optimise import RequirementsSpec
from palpate.optimise.validate_designs import _Candidate
from palpate.simulation import SimulatedUnit
from palpate.simulation import run_trial as virtual
from palpate.study import find_artefact

KNOWN_ROBOT = {"robot_tilt_deg": 1e-6, "robot_depth": 1e-6}


class ExactDots(SimulatedUnit):
    """A unit whose images are the places (m, 2) px of the layout's dots; NaN for those that are not printed."""

    def predict(self, edges: FloatArray) -> FloatArray:
        """Centres of area of the traces of dots; the last is the orientation mark."""
        found = np.full((len(self.printed), 2), np.nan)
        found[self.printed] = project_markers(self.camera, edges).centres[:-1]
        return found

    def render_press(self, press: Press) -> list[FloatArray]:
        """Dots in every image of a press."""
        return [self.predict(edges) for edges in self.press_edges(press)]


def read_unit(bench: virtual.VirtualBench, deviation: Deviation) -> FloatArray:
    """Errors (n, 2) of rx and ry, degrees, of a unit's images after known presses."""
    spec, twin = bench.spec, bench.opened_model
    dots, design = ExactDots(bench.design, deviation, spec.render), bench.design
    rest = dots.predict(dots.edges)
    belief = infer_from_rest(twin, design.layout, design.camera_spec, rest, spec.tolerance, NOISE_PX)
    model, rng = (
        build_unit_model(twin, design.layout, belief, spec.tolerance),
        generator(spec.seed, "directions", deviation.unit),
    )
    known = virtual._known(bench, dots, rng)
    presses = [CalibrationPress(poses, np.array(seen)) for poses, seen, _ in known]
    found = identify(model, presses, NOISE_PX, virtual._robot(bench))
    fitter, errors = PoseFitter(model.with_posterior(found.posterior), NOISE_PX, found.mounting, None), []
    for press in [press for press in virtual.solve_unit_presses(bench, deviation) for _ in range(spec.azimuths)]:
        turned = virtual._turned(press, float(rng.uniform(0, 360)))
        for depth, seen in zip(turned.depth[1:], list(dots.render_press(turned))[1:], strict=True):
            told = fitter.fit(seen).pose
            if depth >= spec.min_depth - 1e-9:
                errors.append(told[:2] - virtual._robot_pose(turned, deviation, float(depth))[:2])
    return np.array(errors)


def designs(folder: Path) -> Iterator[_Candidate]:
    """Winner and rival of a reported search."""
    front = json.loads((folder / "front.json").read_text())
    spec, won = RequirementsSpec.model_validate(front["requirements"]), front["winner"]
    names = {"height": "height_mm", "base_radius": "base_radius_mm", "thickness": "thickness_mm"}
    shape = {name: won[column] for name, column in names.items()} | {"aspect": won["aspect"], "taper": won["taper"]}
    rings = tuple(float(ring) for ring in won["ring_diameters_mm"].split())
    markers = MarkerSpec(count=won["markers"], diameter=won["marker_diameter_mm"], ring_diameters=rings)
    choice = next(one for one in spec.cameras if one.name == won["camera"])
    camera = choice.camera.model_copy(update={"distance": won["distance_mm"]})
    skin = skin_from_data({"kind": "ellipsoid", **shape})
    yield _Candidate(spec, "winner", Design(skin, markers, camera, get_material(won["material"])), won["material"])
    if spec.baseline is not None:
        yield _Candidate.rival(spec)


def main(folder: Path, units: int = 4, robot: str = "") -> None:
    """Print the RMSE of every unit, and of all."""
    store = ArtefactStore(folder / "store")
    for design in designs(folder):
        spec = design.bench.model_copy(update=KNOWN_ROBOT if robot == "known-robot" else {})
        twin = find_artefact(store, design.twin)
        bench = virtual.VirtualBench(spec, design.design, twin, store)
        squares = []
        for unit in range(1, units + 1):
            errors = read_unit(bench, sample_deviation(spec.tolerance, spec.seed, unit))
            squares.append(np.mean(errors**2))
            print(f"{design.title}, unit {unit}: {np.sqrt(squares[-1]):.4f} deg", flush=True)
        print(f"{design.title}, {units} units: {np.sqrt(np.mean(squares)):.4f} deg, foreseen {design.predict(store)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *map(int, sys.argv[2:3]), *sys.argv[3:4])
