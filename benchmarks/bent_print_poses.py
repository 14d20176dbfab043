"""A print that is bent as a whole, read by its twin: are poses right? docs/other_laboratories.md

    python benchmarks/bent_print_poses.py TWIN.h5

Prints of H20 T2, 169 markers: radii off by a smooth law of up to 10 %, flattened by up to 3 %, up to 0.4 mm aside,
dots turned by up to 0.25°, the camera 3 mm off and 4° tilted. Each is photographed at rest and through presses solved
on a finer mesh than the twin's, at µ 0.9, and goes through detection, naming and the fit. The control takes the dots
for where the design has them.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from palpate.calibration import Deviation, PoseFitter, ToleranceSpec, build_unit_model, infer_from_rest
from palpate.camera import CameraSpec, RenderSpec, marker_outlines
from palpate.core import generator
from palpate.design import Design, MarkerSpec, place_markers, place_orientation_mark
from palpate.fea import WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import SensorSpec, Unit, open_sensor
from palpate.simulation import SimulatedUnit
from palpate.surrogate import read_twin

PRINTS = 6
WALLS = ((3.0, 40.0), (6.0, 160.0), (9.0, 285.0))
"""Tilt and azimuth, degrees."""
LIGHT = RenderSpec(vignetting=0.2, unevenness=0.1, blur_px=0.7, noise=2.0)
TOLERANCE = ToleranceSpec(
    camera_offset=4.0, camera_tilt_deg=6.0, camera_distance=2.0, marker_position=0.6, print_shift=1.0
)


@dataclass(frozen=True, eq=False)
class BentPrint(SimulatedUnit):
    """A unit whose markers have the edges (m, k, 3) mm of `bent`."""

    bent: np.ndarray = field(default_factory=lambda: np.empty((0, 0, 3)))

    @property
    def edges(self) -> np.ndarray:
        return self.bent


def bend_print(points, outermost, rng):
    """Places (m, 3) mm of a bent print, before they are laid on the skin."""
    radius, azimuth = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])
    share = radius / outermost
    inner, outer = rng.uniform(-0.10, 0.04), rng.uniform(-0.02, 0.04)
    grown = radius * (1.0 + inner * (1.0 - share) + outer * share)
    grown *= 1.0 + 0.03 * rng.uniform(-1, 1) * np.cos(2.0 * (azimuth - rng.uniform(0, np.pi)))
    azimuth = azimuth + np.radians(0.25) * rng.uniform(-1, 1, len(points))
    return np.column_stack([grown * np.cos(azimuth), grown * np.sin(azimuth)]) + rng.uniform(-0.3, 0.3, 2)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("twin", type=Path)
    twin = read_twin(parser.parse_args().twin)
    skin, layout, nominal = twin.skin, place_markers(twin.skin, MarkerSpec()), CameraSpec()
    material, mesh = get_material("zaid_2024_ecoflex_00_30"), mesh_skin(twin.skin)
    finer = mesh_skin(twin.skin, MeshSpec(cells=round(9 / 8 * (mesh.spec.cells or 16))))
    presses = [
        solve_press(finer, material, WallSpec(tilt_deg=t, azimuth_deg=a, contact=0.9, depth_step=0.8))
        for t, a in WALLS
    ]
    deviation = Deviation(offset_x=2.0, offset_y=-2.2, tilt_x_deg=3.0, tilt_y_deg=-2.6, roll_deg=2.0)
    found, blind = [], []
    for number in range(PRINTS):
        rng = generator(7, "bent print", number)
        designed = np.vstack([layout.positions, place_orientation_mark(skin, layout)])
        x, y = bend_print(designed, float(np.hypot(*layout.positions[:, :2].T).max()), rng).T
        printed = skin.inner_point(np.hypot(x, y), np.arctan2(y, x))
        bent = marker_outlines(skin, printed, layout.diameter)
        scene = BentPrint(Design.of_skin(skin, layout, nominal), deviation, LIGHT, bent)
        unit = Unit(Design.of_skin(skin, layout, nominal), tolerance=TOLERANCE)
        sensor = open_sensor([scene.render_rest()], unit, twin, SensorSpec())
        rest = scene.camera.project(layout.positions)  # the control: as if the print were the design's
        control = PoseFitter(
            build_unit_model(twin, layout, infer_from_rest(twin, layout, nominal, rest, TOLERANCE, 0.02), TOLERANCE),
            0.02,
        )
        for press, (tilt, turn) in zip(presses, WALLS, strict=True):
            truth = tilt * np.cos(np.radians(turn)), tilt * np.sin(np.radians(turn))
            for depth, image in zip(press.depth, scene.render_press(press), strict=True):
                reading = sensor.read(image)
                if depth < 2.0 or reading.sighting is None:
                    continue
                found.append(np.array(reading.pose) - [*truth, depth])
                seen = np.where(reading.sighting.found[:, None], reading.sighting.positions_px, np.nan)
                blind.append(control.fit(seen).pose - [*truth, depth])
        print(f"print {number}: {np.sqrt(np.mean(np.square(found), axis=0)).round(3)} so far", flush=True)
    for name, errors in (("read", found), ("control", blind)):
        rms, most = np.sqrt(np.mean(np.square(errors), axis=0)), np.abs(errors).max(axis=0)
        print(f"{name}: {len(errors)} images, rms rx, ry, depth {rms.round(3)}, at most {most.round(3)}")


if __name__ == "__main__":
    main()
