"""A sensor as an asset: what it weighs by closed forms, and what each simulator makes of it by its own means."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.camera import Camera, CameraSpec, build_camera
from palpate.design import DomeSpec, EllipsoidSpec, build_skin
from palpate.fea import Press, WallSpec
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.study import (
    OPTICAL_FROM_BODY,
    AssetFormat,
    AssetSpec,
    SensorAsset,
    build_asset,
    compute_mass_properties,
    export_asset,
    skin_surface,
)
from presses import solve_press

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")
INNER, OUTER, DENSITY = 0.020, 0.022, 1070.0
POINTS = np.array([[0.0, 0.0, 20.0], [8.0, 0.0, 15.0], [0.0, 8.0, 15.0], [-5.0, 3.0, 10.0]])
"""In the dome, mm."""
LEANING = CameraSpec(offset_x=1.0, offset_y=-2.0, tilt_x_deg=4.0, tilt_y_deg=-3.0, roll_deg=20.0)


def straight(tilt_deg: float = 0.0, depth: float = 4.0, **wall: float) -> Press:
    spec = WallSpec(tilt_deg=tilt_deg, depth=depth, depth_step=0.5, **wall)
    return solve_press(mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=8)), ECOFLEX, spec)


@pytest.fixture(scope="module")
def press() -> Press:
    return straight()


@pytest.fixture(scope="module")
def camera() -> Camera:
    return build_camera(LEANING)


@pytest.fixture(scope="module")
def asset(press: Press, camera: Camera) -> SensorAsset:
    return build_asset(press, camera)


@pytest.fixture(scope="module")
def files(asset: SensorAsset, tmp_path_factory: pytest.TempPathFactory) -> dict[AssetFormat, Path]:
    needs("trimesh")
    folder = tmp_path_factory.mktemp("assets")
    return {to: export_asset(folder / to, asset, to) for to in AssetFormat}


def hemispherical_shell() -> tuple[float, float, np.ndarray]:
    """Mass, height of the centre over the base, and moments about the centre, of a shell with a flat base; SI."""
    powers = {n: OUTER**n - INNER**n for n in (3, 4, 5)}
    mass = DENSITY * 2 * np.pi / 3 * powers[3]
    centre = 3 / 8 * powers[4] / powers[3]
    about_axis = 2 / 5 * mass * powers[5] / powers[3]
    return mass, centre, np.array([about_axis - mass * centre**2] * 2 + [about_axis])


def test_a_hemispherical_shell_weighs_what_its_closed_form_says() -> None:
    mass, centre, moments = hemispherical_shell()
    body = compute_mass_properties(build_skin(DomeSpec()), DENSITY)
    assert body.mass_kg == pytest.approx(mass, rel=1e-6)
    assert body.centre_mm == pytest.approx([0.0, 0.0, 1e3 * centre], abs=1e-5)
    assert body.inertia == pytest.approx(np.diag(moments), rel=1e-6)


@pytest.mark.parametrize(
    "spec", [DomeSpec(height=8), DomeSpec(height=26, thickness=3), EllipsoidSpec(height=14, aspect=0.7)]
)
def test_the_surface_encloses_what_the_mesh_weighs(spec: DomeSpec | EllipsoidSpec) -> None:
    skin = build_skin(spec)
    surface = skin_surface(skin)
    assert surface.is_watertight
    assert surface.volume * 1e-9 * DENSITY == pytest.approx(compute_mass_properties(skin, DENSITY).mass_kg, rel=2e-3)
    far = np.abs(skin.distance(surface.points) - np.repeat([skin.thickness, 0.0], len(surface.points) // 2))
    assert far.max() < 1e-6


def test_mujoco_finds_the_mass_and_inertia_of_the_file_itself(files: dict[AssetFormat, Path]) -> None:
    """By its own integration over the STL, which is a little inside the skin."""
    mujoco = needs("mujoco")
    mass, centre, moments = hemispherical_shell()
    model = mujoco.MjModel.from_xml_path(str(files[AssetFormat.MJCF]))
    found = np.sort(model.body_inertia[1]) + np.sort(model.body_inertia[2])
    assert model.body_subtreemass[1] == pytest.approx(mass, rel=2e-6)
    assert model.body_ipos[1:] == pytest.approx(np.tile([0, 0, centre], (2, 1)), abs=1e-6)
    assert found == pytest.approx(np.sort(moments), rel=1e-5)
    own = mujoco.MjModel.from_xml_string(
        f"""<mujoco><compiler meshdir="{files[AssetFormat.MJCF].parent}"/>
        <asset><mesh name="m" file="palpate_h20_t2_skin.stl" scale="0.001 0.001 0.001" inertia="exact"/></asset>
        <worldbody><body><freejoint/><geom type="mesh" mesh="m" density="{DENSITY:g}"/></body></worldbody></mujoco>"""
    )
    assert own.body_mass[1] == pytest.approx(mass, rel=2e-3)
    assert own.body_ipos[1] == pytest.approx([0, 0, centre], abs=5e-6)
    assert np.sort(own.body_inertia[1]) == pytest.approx(found, rel=4e-3)


def test_mujocos_camera_sees_points_where_ours_does(files: dict[AssetFormat, Path], camera: Camera) -> None:
    """By the frustum through which MuJoCo renders; its sensor of projections leaves the principal point out."""
    mujoco = needs("mujoco")
    model = mujoco.MjModel.from_xml_path(str(files[AssetFormat.MJCF]))
    data, view = mujoco.MjData(model), mujoco.MjvCamera()
    mujoco.mj_forward(model, data)
    view.type, view.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    scene = mujoco.MjvScene(model, 10)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, view, mujoco.mjtCatBit.mjCAT_ALL, scene)
    looks = scene.camera[0]
    low = np.array([looks.frustum_center - looks.frustum_width, looks.frustum_bottom])
    high = np.array([looks.frustum_center + looks.frustum_width, looks.frustum_top])
    seen = (POINTS / 1e3 - data.cam_xpos[0]) @ data.cam_xmat[0].reshape(3, 3)
    share = (seen[:, :2] / -seen[:, 2:] * looks.frustum_near - low) / (high - low)
    size = np.array([camera.width_px, camera.height_px])
    pixels = np.column_stack([share[:, 0], 1 - share[:, 1]]) * size - 0.5
    assert pixels == pytest.approx(camera.project(POINTS), abs=0.01)


def test_a_weight_on_the_asset_sinks_as_deep_as_the_press_says(files: dict[AssetFormat, Path], press: Press) -> None:
    """Whatever its inertia: MuJoCo's own contact would yield in proportion to it."""
    mujoco = needs("mujoco")
    for mass, weight in ((0.015, 9.81), (0.15, 0.981)):
        spec = mujoco.MjSpec.from_file(str(files[AssetFormat.MJCF]))
        spec.option.gravity = [0, 0, -weight]
        body = spec.worldbody.add_body(pos=[0, 0, 0.0222])
        body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.03, 0.03, 1e-4], mass=mass)
        model = spec.compile()
        data = mujoco.MjData(model)
        for _ in range(4000):
            mujoco.mj_step(model, data)
        depth = float(np.interp(mass * weight, press.force[:, 2], press.depth))
        assert 1e3 * data.sensor(f"{spec.modelname}_depth").data[0] == pytest.approx(depth, abs=0.05)
        assert np.abs(data.qvel).max() < 1e-3


def test_what_carries_the_asset_feels_its_weight_in_every_attitude(files: dict[AssetFormat, Path]) -> None:
    mujoco = needs("mujoco")
    spec = mujoco.MjSpec.from_file(str(files[AssetFormat.MJCF]))
    spec.worldbody.first_body().add_freejoint()
    model = spec.compile()
    data = mujoco.MjData(model)
    mass, centre, _ = hemispherical_shell()
    for turn in ([1, 0, 0, 0], [0.5, 0.5, 0.5, 0.5], [0, 1, 0, 0]):
        data.qpos[3:7] = turn
        mujoco.mj_forward(model, data)
        held = data.qfrc_bias - data.qfrc_passive
        arm = data.xmat[1].reshape(3, 3).T @ [0, 0, 9.81 * mass]
        assert held[:3] == pytest.approx([0, 0, 9.81 * mass], rel=1e-5, abs=1e-9)
        assert held[3:6] == pytest.approx(np.cross([0, 0, centre], arm), rel=1e-4, abs=1e-9)
        assert held[6] == pytest.approx(0.0, abs=1e-9), "the dome does not sag on its spring"


def test_the_frames_of_a_urdf_are_those_of_rep_103(files: dict[AssetFormat, Path], camera: Camera) -> None:
    yourdfpy = needs("yourdfpy")
    robot = yourdfpy.URDF.load(str(files[AssetFormat.URDF]))
    name = robot.base_link
    optical = robot.get_transform(f"{name}_camera_optical", name)
    assert optical[:3, 3] == pytest.approx([0.001, -0.002, -0.048])
    seen = (POINTS / 1e3 - optical[:3, 3]) @ optical[:3, :3]
    spec = camera.spec
    pixels = seen[:, :2] / seen[:, 2:] * [spec.fx_px, spec.fy_px] + [spec.cx_px, spec.cy_px]
    assert pixels == pytest.approx(camera.project(POINTS), abs=1e-6)
    body = robot.get_transform(f"{name}_camera", f"{name}_camera_optical")[:3, :3]
    forward, left, up = np.eye(3) @ body.T
    assert forward == pytest.approx([0, 0, 1], abs=1e-9), "x the way it looks"
    assert left == pytest.approx([-1, 0, 0], abs=1e-9)
    assert up == pytest.approx([0, -1, 0], abs=1e-9)
    assert body == pytest.approx(OPTICAL_FROM_BODY, abs=1e-9)
    mass, centre, moments = hemispherical_shell()
    inertial = robot.robot.links[0].inertial
    assert inertial.mass == pytest.approx(mass, rel=2e-6)
    assert inertial.origin[:3, 3] == pytest.approx([0, 0, centre], abs=1e-6)
    assert inertial.inertia == pytest.approx(np.diag(moments), rel=1e-5)
    assert robot.scene.bounds[:, 2] == pytest.approx([0.0, OUTER], abs=1e-6), "metres, apex along z"


def test_usd_reads_mass_mesh_and_camera(files: dict[AssetFormat, Path], camera: Camera) -> None:
    needs("pxr")
    from pxr import Gf, Usd, UsdGeom, UsdPhysics

    stage = Usd.Stage.Open(str(files[AssetFormat.USD]))
    root = stage.GetDefaultPrim()
    body = UsdPhysics.MassAPI(root)
    mass, centre, moments = hemispherical_shell()
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert body.GetMassAttr().Get() == pytest.approx(mass, rel=2e-6)
    assert body.GetCenterOfMassAttr().Get() == pytest.approx((0, 0, centre), abs=1e-6)
    assert sorted(body.GetDiagonalInertiaAttr().Get()) == pytest.approx(sorted(moments), rel=1e-3)
    axes = np.array(Gf.Matrix3d(Gf.Rotation(body.GetPrincipalAxesAttr().Get())))
    turned = axes.T @ np.diag(body.GetDiagonalInertiaAttr().Get()) @ axes
    assert turned == pytest.approx(np.diag(moments), rel=1e-3, abs=1e-11)
    mesh = UsdGeom.Mesh(root.GetChild("skin"))
    assert root.GetChild("skin").HasAPI(UsdPhysics.CollisionAPI)
    assert UsdGeom.Boundable(mesh).ComputeExtent(Usd.TimeCode.Default())[1][2] == pytest.approx(OUTER, abs=1e-6)
    seen = UsdGeom.Camera(root.GetChild("camera")).GetCamera().frustum
    through = np.array(seen.ComputeViewMatrix() * seen.ComputeProjectionMatrix())
    clip = np.column_stack([POINTS / 1e3, np.ones(len(POINTS))]) @ through
    size = np.array([camera.width_px, camera.height_px])
    pixels = (clip[:, :2] / clip[:, 3:] * [1, -1] + 1) / 2 * size - 0.5
    assert pixels == pytest.approx(camera.project(POINTS), abs=0.01)


def test_contacts_of_a_urdf_are_the_line_through_the_press(files: dict[AssetFormat, Path], press: Press) -> None:
    contact = ElementTree.parse(files[AssetFormat.URDF]).getroot().find("gazebo")
    assert contact is not None
    stiffness = float(contact.findtext("kp") or 0)
    depth, force = press.depth / 1e3, press.force[:, 2]
    assert stiffness == pytest.approx((depth @ force) / (depth @ depth), rel=1e-9)
    assert force[1] / depth[1] < stiffness < force[-1] / depth[-1], "a dome grows stiffer"


def test_density_and_damping_are_chosen(press: Press, asset: SensorAsset, camera: Camera) -> None:
    heavy = build_asset(press, camera, AssetSpec(density=2140.0, damping_ratio=0.5))
    assert heavy.body.mass_kg == pytest.approx(2 * asset.body.mass_kg)
    assert heavy.damping == pytest.approx(np.sqrt(0.5) * asset.damping)
    omega = np.sqrt(asset.stiffness / asset.body.mass_kg)
    assert asset.damping / (2 * asset.body.mass_kg * omega) == pytest.approx(1.0)


def test_a_spring_never_falls_even_where_the_press_softens(press: Press, camera: Camera) -> None:
    depth = press.depth / press.depth[-1]
    soft = replace(press, force=press.force * 0.0 + (depth * (1.0 - 1.95 * depth + 1.1 * depth**2))[:, None])
    asset = build_asset(soft, camera)
    slope = asset.spring @ [np.ones(50), *(k * np.linspace(0, asset.reach, 50) ** (k - 1) for k in (2, 3))]
    assert (np.diff(soft.force[:, 2]) < 0).any(), "the press does fall"
    assert (slope >= 0).all()
    assert asset.spring_rms > 0.005, "and it is said how far the spring is off"


def test_what_is_no_straight_press_or_too_short_is_refused(camera: Camera) -> None:
    with refused("asset-wall-not-straight", "tilt 4"):
        build_asset(straight(4.0, 1.0), camera)
    with refused("asset-press-short"):
        build_asset(straight(0.0, 1.0), camera)


@pytest.fixture(scope="module")
def pair(press: Press, camera: Camera, tmp_path_factory: pytest.TempPathFactory) -> dict[AssetFormat, list[Path]]:
    """Files of two sensors of one design with names of their own."""
    needs("trimesh")
    folder = tmp_path_factory.mktemp("pair")
    assets = [build_asset(press, camera, AssetSpec(name=name)) for name in ("left", "right")]
    return {to: [export_asset(folder / f"{one.name}_{to}", one, to) for one in assets] for to in AssetFormat}


def test_two_named_sensors_load_in_one_mujoco_model(pair: dict[AssetFormat, list[Path]], tmp_path: Path) -> None:
    mujoco = needs("mujoco")
    robot = ElementTree.fromstring("<mujoco><asset/><worldbody/><sensor/><compiler angle='radian'/></mujoco>")
    for path in pair[AssetFormat.MJCF]:
        for part in ElementTree.parse(path).getroot():
            if part.tag != "compiler":
                robot.find(part.tag).extend(part)
        for mesh in path.parent.glob("*.stl"):
            (tmp_path / mesh.name).write_bytes(mesh.read_bytes())
    (tmp_path / "robot.xml").write_text(ElementTree.tostring(robot, encoding="unicode"))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert (model.ncam, model.nmesh, model.njnt) == (2, 2, 2)
    for kind, tail in (
        ("BODY", ""),
        ("BODY", "_skin"),
        ("JOINT", "_depth"),
        ("CAMERA", "_camera"),
        ("MESH", "_skin"),
    ):
        numbers = [
            mujoco.mj_name2id(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), f"{name}{tail}")
            for name in ("left", "right")
        ]
        assert min(numbers) >= 0
        assert numbers[0] != numbers[1]


def test_two_named_sensors_load_in_one_urdf(pair: dict[AssetFormat, list[Path]], tmp_path: Path) -> None:
    yourdfpy = needs("yourdfpy")
    robot = ElementTree.fromstring("<robot name='hand'><link name='palm'/></robot>")
    for path, name in zip(pair[AssetFormat.URDF], ("left", "right"), strict=True):
        robot.extend(ElementTree.parse(path).getroot())
        joint = ElementTree.SubElement(robot, "joint", name=f"{name}_mount", type="fixed")
        ElementTree.SubElement(joint, "parent", link="palm")
        ElementTree.SubElement(joint, "child", link=name)
        for mesh in path.parent.glob("*.stl"):
            (tmp_path / mesh.name).write_bytes(mesh.read_bytes())
    (tmp_path / "hand.urdf").write_text(ElementTree.tostring(robot, encoding="unicode"))
    loaded = yourdfpy.URDF.load(str(tmp_path / "hand.urdf"), load_meshes=True)
    assert {"palm", "left", "right", "left_camera", "right_camera_optical"} <= set(loaded.link_map)
    assert len(loaded.scene.geometry) == 2


def test_two_named_sensors_load_in_one_usd_stage(pair: dict[AssetFormat, list[Path]]) -> None:
    needs("pxr")
    from pxr import Sdf, Usd

    stage = Usd.Stage.CreateInMemory()
    for path in pair[AssetFormat.USD]:
        layer = Sdf.Layer.FindOrOpen(str(path))
        Sdf.CopySpec(
            layer, layer.GetPrimAtPath(f"/{layer.defaultPrim}").path, stage.GetRootLayer(), f"/{layer.defaultPrim}"
        )
    assert [one.GetName() for one in stage.GetPseudoRoot().GetChildren()] == ["left", "right"]
    bound = stage.GetPrimAtPath("/right/skin").GetRelationship("material:binding:physics").GetTargets()
    assert [str(one) for one in bound] == ["/right/silicone"]


@pytest.mark.parametrize("name", ["world", "1st", "left finger", "left/finger", "é"])
def test_a_name_that_not_every_format_takes_is_refused(name: str) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        AssetSpec(name=name)
    assert f"'{name}'" in str(caught.value)


def test_a_folder_that_is_there_is_left_alone(asset: SensorAsset, tmp_path: Path) -> None:
    needs("trimesh")
    with refused("folder-exists"):
        export_asset(tmp_path, asset, AssetFormat.MJCF)


def test_a_gel_inside_is_weighed_too() -> None:
    """Half a ball and its wall, by the volumes of balls."""
    skin = DomeSpec(height=20, thickness=1).build()
    both = compute_mass_properties(skin, 1000.0, filled=True)
    assert both.mass_kg == pytest.approx(1e-6 * 2 / 3 * np.pi * 21.0**3, rel=1e-5)
    assert both.centre_mm[2] == pytest.approx(3 / 8 * 21.0, rel=1e-5)
    assert compute_mass_properties(skin, 1000.0).mass_kg < 0.2 * both.mass_kg


def test_a_force_curve_needs_four_images_before_the_press_jumps(press: Press, camera: Camera) -> None:
    assert build_asset(replace(press, jump_depth=float(press.depth[4])), camera).reach == pytest.approx(1.5e-3)
    with refused("asset-few-images", "3", "4"):
        build_asset(replace(press, jump_depth=float(press.depth[3])), camera)


def test_usd_sees_by_a_lens_of_two_focal_lengths_and_a_principal_point_aside(press: Press, tmp_path: Path) -> None:
    needs("pxr")
    from pxr import Usd, UsdGeom

    wide = build_camera(LEANING.model_copy(update={"fx_px": 250.0, "fy_px": 380.0, "cx_px": 150.0, "cy_px": 160.0}))
    path = export_asset(tmp_path / "wide", build_asset(press, wide), AssetFormat.USD)
    stage = Usd.Stage.Open(str(path))
    seen = UsdGeom.Camera(stage.GetDefaultPrim().GetChild("camera")).GetCamera().frustum
    through = np.array(seen.ComputeViewMatrix() * seen.ComputeProjectionMatrix())
    clip = np.column_stack([POINTS / 1e3, np.ones(len(POINTS))]) @ through
    pixels = (clip[:, :2] / clip[:, 3:] * [1, -1] + 1) / 2 * [wide.width_px, wide.height_px] - 0.5
    assert pixels == pytest.approx(wide.project(POINTS), abs=0.01)
