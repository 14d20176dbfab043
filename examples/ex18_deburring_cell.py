"""A six-axis robot in MuJoCo aligns its drill with plates: search, touch, rotate, retract, and move over the hole.

`python examples/ex18_deburring_cell.py 100 cell.png residuals.png` draws the cell and the residual angles.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import palpate as pp
from palpate.calibration import CONTACT_STATE, ToleranceSpec, sample_deviation
from palpate.core.state import State
from palpate.design import TILT_SPACE, Design, DomeSpec, wall_normal
from palpate.mechanics import SolverSpec
from palpate.sensor import Aligner, AlignSpec, Placement, Robot, Tool, Unit
from palpate.simulation import DEGRADED, SimulatedUnit, TwinBackend
from palpate.study import AssetFormat, build_asset, export_asset
from palpate.surrogate import Twin, build_twin, twin_derivatives

DESIGN = Design(DomeSpec(), pp.MarkerSpec(count=61), material=pp.get_material("zaid_2024_ecoflex_00_30"))
SENSOR = Placement(position=np.array([0.0, 0.0, 60.0]))
DRILL = np.array([70.0, 0.0, 55.0])
"""Tip of the drill on the flange, mm, behind that of the sensor; its axis is parallel to the flange's z."""
LINKS = (  # name, position in the link before, turned by 90° about y, axis of the joint, end of its rod
    ("shoulder", "0 0 .163", False, "0 0 1", "0 .1 0"),
    ("upper", "0 .138 0", True, "0 1 0", "0 0 .425"),
    ("fore", "0 -.131 .425", False, "0 1 0", "0 0 .392"),
    ("wrist1", "0 0 .392", True, "0 1 0", "0 .1 0"),
    ("wrist2", "0 .127 0", False, "0 0 1", "0 0 .1"),
    ("wrist3", "0 0 .1", False, "0 1 0", "0 .08 0"),
)
"""A robot of the size of a UR5e (its data sheet); lengths in m."""
HOME = np.radians([-90.0, -100.0, 110.0, -100.0, -90.0, 0.0])
ENCODER_DEG, STEPS = 0.01, 60
"""Error of each joint's zero, and steps of 2 ms of a move."""


def solve_twin() -> Twin:
    mesh, presses = pp.mesh_skin(DESIGN.skin, pp.MeshSpec(cells=6)), []
    for contact in ("no-slip", 0.8):
        for tilt in (0.0, 4.0, 8.0, 12.0):
            wall = pp.WallSpec(tilt_deg=tilt, depth=6, depth_step=0.5, contact=contact)
            solver = SolverSpec(derivatives=twin_derivatives(filled=False, friction=wall.friction))
            presses.append(pp.solve_press(mesh, DESIGN.material, wall, solver))
    return build_twin(presses)


def load_cell() -> mujoco.MjModel:
    """Return the robot with the exported sensor, a drill, and a plate that is placed by hand."""
    body, servos = "", ""
    for name, place, turned, axis, rod in LINKS:
        body += f'<body name="{name}" pos="{place}" quat="1 0 {int(turned)} 0" gravcomp="1"><joint name="{name}" '
        body += f'axis="{axis}" damping="500" armature="1"/><geom type="capsule" size=".04" mass="3" '
        body += f'fromto="0 0 0 {rod}" contype="0" conaffinity="0" rgba=".6 .65 .7 1"/>'
        servos += f'<position joint="{name}" kp="40000" kv="2000"/>'
    x, y, z = DRILL / 1e3
    body += '<body name="flange" pos="0 .1 0" quat="-1 1 0 0" gravcomp="1"><site name="sensor" pos="0 0 .06"/>'
    rods = (("0 0 0 0 0 .058", ".022", ".3 .3 .35 1"), (f"0 0 .02 {x} 0 .02", ".012", ".3 .3 .35 1"))
    for ends, radius, colour in (*rods, (f"{x} {y} 0 {x} {y} {z}", ".003", ".9 .5 .1 1")):
        body += f'<geom type="cylinder" size="{radius}" fromto="{ends}" mass=".1" contype="0" conaffinity="0" '
        body += f'rgba="{colour}"/>'
    body += "</body>" * (len(LINKS) + 1)
    plate = '<geom type="box" size=".2 .2 .002" pos="0 0 -.002" rgba=".75 .78 .8 1"/><geom type="cylinder" '
    plate += 'size=".004 .0022" pos="0 0 -.002" contype="0" conaffinity="0" rgba=".1 .1 .1 1"/>'
    world = f'<light pos="0 0 3"/><body name="plate" mocap="true">{plate}</body>{body}'
    options = '<compiler angle="radian"/><option integrator="implicitfast"/>'
    options += '<asset><texture type="skybox" builtin="flat" rgb1="1 1 1" width="16" height="96"/></asset>'
    scene = mujoco.MjSpec.from_string(
        f"<mujoco>{options}<worldbody>{world}</worldbody><actuator>{servos}</actuator></mujoco>"
    )
    straight = pp.solve_press(
        pp.mesh_skin(DESIGN.skin, pp.MeshSpec(cells=6)), DESIGN.material, pp.WallSpec(depth=4, depth_step=0.5)
    )
    with TemporaryDirectory() as folder:
        asset = export_asset(Path(folder) / "sensor", build_asset(straight, DESIGN.camera), AssetFormat.MJCF)
        sensor = mujoco.MjSpec.from_file(str(asset))
        scene.attach(sensor, site=scene.site("sensor"), prefix="tool_")
        return scene.compile()


class Cell(Robot):
    """The simulated robot, whose joints have small errors, and the sensor's camera."""

    def __init__(self, model: mujoco.MjModel, twin: Twin, seed: int) -> None:
        self.model, self.data, self.rng = model, mujoco.MjData(model), np.random.default_rng(seed)
        self.nominal = mujoco.MjData(model)
        deviation = sample_deviation(ToleranceSpec(), seed, 1)
        self.images = TwinBackend(SimulatedUnit(DESIGN, deviation, DEGRADED), twin)
        self.offsets = np.radians(ENCODER_DEG) * self.rng.normal(size=6)
        self.point, self.normal = np.zeros(3), np.array([0.0, 0.0, -1.0])

    def place(self, tilt_deg: np.ndarray) -> None:
        """Move home, and place a plate with a tilt (2,) under the drill."""
        self.data.mocap_pos[0] = [0.0, 0.0, -1.0]
        self.data.qpos[:6] = self.data.ctrl[:] = HOME
        mujoco.mj_forward(self.model, self.data)
        home = self.true_pose()
        self.normal = home.rotation @ wall_normal(*np.radians(tilt_deg))
        self.point = home.apply(DRILL + np.array([0.0, 0.0, 45.0]))
        self.data.mocap_pos[0] = self.point / 1e3
        mujoco.mju_quatZ2Vec(self.data.mocap_quat[0], -self.normal)
        self._settle()

    def move(self, base_from_flange: Placement) -> None:
        goal = self._joints(base_from_flange) + self.offsets
        start = self.data.ctrl.copy()
        for share in np.linspace(0.0, 1.0, STEPS + 1)[1:]:
            self.data.ctrl[:] = start + share * (goal - start)
            mujoco.mj_step(self.model, self.data)
        self._settle()

    def flange_pose(self) -> Placement:
        return self._pose(self.data.qpos[:6] - self.offsets)

    def true_pose(self) -> Placement:
        return self._pose(self.data.qpos[:6])

    def drill_error(self) -> float:
        """Angle between drill and plate normal, degrees."""
        axis = self.true_pose().rotation[:, 2]
        return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(axis, self.normal)), axis @ self.normal)))

    def next_image(self) -> np.ndarray:
        unit = self.images.unit
        seed = int(self.rng.integers(2**31))
        pose = (self.true_pose() @ SENSOR).wall_pose(self.point, self.normal, DESIGN.skin, unit.deviation.thickness)
        if pose[2] <= 0.0:
            return unit.render(unit.edges, seed)
        contact = State.zeros(CONTACT_STATE).add(TILT_SPACE.names, pose).replace(inverse_friction=0.5)
        return unit.render(self.images.edges(contact), seed)

    def _settle(self) -> None:
        for _ in range(5 * STEPS):
            mujoco.mj_step(self.model, self.data)
            if np.abs(self.data.qvel[:6]).max() < 1e-5:
                return

    def _pose(self, joints: np.ndarray) -> Placement:
        self.nominal.qpos[:6] = joints
        mujoco.mj_kinematics(self.model, self.nominal)
        body = self.model.body("flange").id
        return Placement(self.nominal.xmat[body].reshape(3, 3).copy(), 1e3 * self.nominal.xpos[body])

    def _joints(self, goal: Placement) -> np.ndarray:
        """Solve the inverse kinematics by Newton's method from the present joints."""
        joints, body = self.data.ctrl - self.offsets, self.model.body("flange").id
        for _ in range(20):
            here = self._pose(joints)
            mujoco.mj_comPos(self.model, self.nominal)
            along, about = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
            mujoco.mj_jacBody(self.model, self.nominal, along, about, body)
            turn = np.zeros(3)
            quat = np.zeros(4)
            mujoco.mju_mat2Quat(quat, (goal.rotation @ here.rotation.T).ravel())
            mujoco.mju_quat2Vel(turn, quat, 1.0)
            miss = np.concatenate([(goal.position - here.position) / 1e3, turn])
            if np.abs(miss).max() < 1e-9:
                break
            joints = joints + np.linalg.solve(np.vstack([along, about])[:, :6], miss)
        return joints


def run_plates(plates: int, cell: Cell, twin: Twin) -> np.ndarray:
    """Align the drill to plates, retract and move over the hole; return the residual angles (n,), degrees."""
    unit = Unit(DESIGN)
    sensor = pp.open_sensor([cell.images.unit.render_rest()], unit, twin)
    cell.place(np.zeros(2))
    tool = Aligner(cell, sensor, cell.next_image, Tool(SENSOR), AlignSpec(search=40.0)).find_offset()
    residuals = []
    for _ in range(plates):
        tilt, turn = 8.0 * np.sqrt(cell.rng.uniform()), cell.rng.uniform(0.0, 2.0 * np.pi)
        cell.place(tilt * np.array([np.cos(turn), np.sin(turn)]))
        Aligner(cell, sensor, cell.next_image, tool, AlignSpec(search=40.0)).align()
        here = cell.flange_pose()
        above = here.moved(-20.0 * here.rotation[:, 2])
        cell.move(above)
        cell.move(above.moved(cell.point - above.apply(DRILL + np.array([0.0, 0.0, 35.0]))))  # the spindle feeds on
        residuals.append(cell.drill_error())
    return np.array(residuals)


def draw(cell: Cell, residuals: np.ndarray, picture: str, histogram: str) -> None:
    """Draw the cell (needs EGL or OSMesa) and the residual angles into files."""
    camera = mujoco.MjvCamera()
    camera.lookat, camera.distance, camera.azimuth, camera.elevation = [0.1, -0.36, 0.33], 0.75, 40.0, -12.0
    with mujoco.Renderer(cell.model, 480, 640) as renderer:
        renderer.update_scene(cell.data, camera)
        plt.imsave(picture, renderer.render())
    figure, axis = plt.subplots(figsize=(6, 3), layout="constrained")
    axis.hist(residuals, bins=np.arange(0.0, max(0.55, residuals.max()) + 0.02, 0.02))
    axis.axvline(0.5, color="C3")
    axis.set(xlabel="angle between drill and plate normal (deg)", ylabel="plates")
    figure.savefig(histogram)


def main(plates: int = 4, picture: str = "", histogram: str = "") -> float:
    twin = solve_twin()
    cell = Cell(load_cell(), twin, seed=3)
    residuals = run_plates(plates, cell, twin)
    middle, high = np.quantile(residuals, [0.5, 0.95])
    print(f"{plates} plates: median {middle:.3f}°, 95 % below {high:.3f}°, maximum {residuals.max():.3f}°")
    if picture:
        draw(cell, residuals, picture, histogram)
    return float(residuals.max())


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]), *sys.argv[2:])
