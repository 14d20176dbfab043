"""A wall presses the sensor in MuJoCo, and the twin says where its dots are seen."""

import time
from pathlib import Path
from tempfile import TemporaryDirectory

import mujoco
import numpy as np

import palpate as pp
from palpate.camera import build_camera
from palpate.fea import Press
from palpate.mechanics import SolverSpec
from palpate.sensor import tilt_from_normal
from palpate.study import AssetFormat, build_asset, export_asset
from palpate.surrogate import TWIN_DERIVATIVES, Twin, build_twin

TILTS, STEPS = (0.0, 4.0, 8.0, 12.0), 2000


def press(tilt_deg: float) -> Press:
    mesh = pp.mesh_skin(pp.build_skin(pp.DomeSpec()), pp.MeshSpec(cells=6))
    wall = pp.WallSpec(tilt_deg=tilt_deg, depth=4, depth_step=0.5)
    return pp.solve_press(
        mesh, pp.get_material("zaid_2024_ecoflex_00_30"), wall, SolverSpec(derivatives=TWIN_DERIVATIVES)
    )


def load(straight: Press) -> mujoco.MjModel:
    """The asset, and a wall that is moved by hand."""
    with TemporaryDirectory() as folder:
        asset = build_asset(straight, build_camera())
        scene = mujoco.MjSpec.from_file(str(export_asset(Path(folder) / "sensor", asset, AssetFormat.MJCF)))
        wall = scene.worldbody.add_body(name="wall", mocap=True)
        wall.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.05, 0.05, 0.01], quat=[0, 1, 0, 0])
        return scene.compile()


def run(model: mujoco.MjModel, twin: Twin) -> tuple[float, np.ndarray]:
    """Press to 3 mm while the wall leans over to 5°; depth in mm, and the dots' pixels of every step."""
    layout, camera = pp.place_markers(twin.skin, pp.MarkerSpec(count=169)), build_camera()
    dots, data, seen = twin.with_markers(layout.positions), mujoco.MjData(model), []
    for share in np.linspace(0.0, 1.0, STEPS):
        lean = np.radians(5.0 * share)
        normal = np.array([0.0, -np.sin(lean), np.cos(lean)])
        data.mocap_pos[0] = (twin.skin.support_point(normal) - [0.0, 0.0, 3.0 * share]) / 1e3
        data.mocap_quat[0] = [np.cos(lean / 2), np.sin(lean / 2), 0.0, 0.0]
        mujoco.mj_step(model, data)
        depth = 1e3 * data.sensordata[0]
        rx, ry = tilt_from_normal(data.xmat[model.body("wall").id].reshape(3, 3)[:, 2])
        seen.append(camera.project(dots.evaluate(np.array([rx, ry, depth]), inverse_friction=0.0).positions))
    return depth, np.array(seen)


def main() -> float:
    presses = [press(tilt) for tilt in TILTS]
    model, twin = load(presses[0]), build_twin(presses)
    run(model, twin)  # compiles
    start = time.process_time()
    depth, seen = run(model, twin)
    rate = len(seen) / (time.process_time() - start)
    print(f"{depth:.2f} mm deep; the dots went up to {np.linalg.norm(seen[-1] - seen[0], axis=1).max():.1f} px")
    print(f"at least 1000 images a second on one core: {rate > 1000}")
    return depth


if __name__ == "__main__":
    main()
