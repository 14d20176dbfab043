"""Recordings in the layouts of LeRobot, ALOHA, robomimic, the TacTip toolkit, NPZ and Zarr, drawn with a seed."""

import gc
import json
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import h5py
import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
import zarr
from scipy.spatial.transform import Rotation

from errors import refused
from palpate.core import PalpateError
from palpate.datasets import ColumnMapping, Recording, RecordingTable, read_recording, to_surface

COUNT, PRESSES = 24, 8
RANDOM = np.random.default_rng(7)
POSES = RANDOM.uniform([-9, -9, 1], [9, 9, 20], (COUNT, 3))
IMAGES = RANDOM.integers(0, 255, (COUNT, 20, 24, 3)).astype(np.uint8)
PRESS = np.repeat(np.arange(PRESSES), COUNT // PRESSES)
JPEG = [np.frombuffer(cv2.imencode(".png", image)[1], np.uint8) for image in IMAGES]
NAMES = ("rx_deg", "ry_deg", "depth_mm")
LAYOUTS: dict[str, Callable[[], object]] = {
    "colour": lambda: IMAGES,
    "grey": lambda: IMAGES[..., 1],
    "channels first": lambda: np.moveaxis(IMAGES, -1, 1),
    "one channel first": lambda: IMAGES[:, None, :, :, 1],
    "fractions": lambda: (IMAGES / 255.0).astype(np.float32),
    "whole numbers as floats": lambda: IMAGES[..., 1].astype(np.float32),
    "channels first, fractions": lambda: np.moveaxis(IMAGES / 255.0, -1, 1),
    "int64": lambda: IMAGES.astype(np.int64),
    "16 bit": lambda: IMAGES.astype(np.uint16) * 16,
}


def check(recording: Recording, scale: float = 1.0, channel: int | None = None) -> None:
    assert len(recording) == COUNT
    assert recording.presses == PRESSES
    assert recording.targets == pytest.approx(POSES, abs=1e-4)
    (image,) = recording.images.read([3])
    assert not isinstance(image, PalpateError), image
    wanted = IMAGES[3] if channel is None else IMAGES[3, ..., channel]
    assert np.squeeze(image) * scale == pytest.approx(wanted, abs=1e-3)


def write_h5(path: Path, images: object, where: str = "images") -> None:
    with h5py.File(path, "w") as file:
        file[where] = images
        file["poses"] = POSES
        file["poses"].attrs["columns"] = NAMES
        file["press"] = PRESS


@pytest.mark.parametrize("ending", ["h5", "npz", "zarr"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_images_of_any_layout_and_type_are_read(layout: str, ending: str, tmp_path: Path) -> None:
    images, path = np.asarray(LAYOUTS[layout]()), tmp_path / f"a.{ending}"
    poses = dict(zip(NAMES, POSES.T, strict=True))
    if ending == "h5":
        write_h5(path, images)
    elif ending == "npz":
        np.savez(path, images=images, press=PRESS, **poses)
    else:
        root = zarr.open_group(str(path), mode="w")
        for name, array in {"data/images": images, **{f"data/{name}": one for name, one in poses.items()}}.items():
            root[name] = array
        root["meta/episode_ends"] = np.arange(1, PRESSES + 1) * (COUNT // PRESSES)
    scale = 255.0 if "fraction" in layout else 1 / 16 if layout == "16 bit" else 1.0
    check(
        read_recording(path), scale, 1 if layout in ("grey", "one channel first", "whole numbers as floats") else None
    )


@pytest.mark.parametrize("padded", [False, True])
def test_rows_of_compressed_files_are_decoded(padded: bool, tmp_path: Path) -> None:
    longest = max(map(len, JPEG))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        if padded:
            file["images"] = np.stack([np.pad(one, (0, longest - len(one))) for one in JPEG])
        else:
            cells = file.create_dataset("images", (COUNT,), h5py.vlen_dtype(np.uint8))
            for number, one in enumerate(JPEG):
                cells[number] = one
        file["press"] = PRESS
        for name, values in zip(NAMES, POSES.T, strict=True):
            file[name] = values
    check(read_recording(tmp_path / "a.h5"))


def test_a_folder_of_aloha_episodes_is_one_recording(tmp_path: Path) -> None:
    for press in range(PRESSES):
        rows = press == PRESS
        with h5py.File(tmp_path / f"episode_{press}.hdf5", "w") as file:
            file["observations/images/tactile"] = IMAGES[rows]
            file["observations/images/wrist"] = IMAGES[rows][:, ::2, ::2]
            file["observations/pose"] = POSES[rows]
            file["observations/pose"].attrs["columns"] = NAMES
    check(read_recording(tmp_path, ColumnMapping(image="tactile")))
    with refused("recording-several-cameras", "images/tactile", "images/wrist"):
        read_recording(tmp_path)
    with refused("column-unknown", "elbow"):
        read_recording(tmp_path, ColumnMapping(image="elbow"))


def test_robomimic_demonstrations_are_presses(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        for press in range(PRESSES):
            rows = press == PRESS
            for camera in ("agentview_image", "tactile_image"):
                file[f"data/demo_{press}/obs/{camera}"] = IMAGES[rows]
            file[f"data/demo_{press}/obs/pose"] = POSES[rows]
            file[f"data/demo_{press}/obs/pose"].attrs["columns"] = NAMES
    check(read_recording(tmp_path / "a.hdf5", ColumnMapping(image="tactile_image")))


def write_lerobot(folder: Path, cameras: tuple[str, ...], version: int = 3) -> None:
    features = {name: {"dtype": "image", "shape": [20, 24, 3], "names": None} for name in cameras}
    about = {"observation.state": {"dtype": "float32", "shape": [3], "names": list(NAMES)}}
    about |= {name: {"dtype": "int64", "shape": [1], "names": None} for name in ("frame_index", "episode_index")}
    about["task"] = {"dtype": "string", "shape": [1], "names": None}
    (folder / "meta").mkdir(parents=True)
    (folder / "meta" / "info.json").write_text(json.dumps({"fps": 10, "features": features | about}))
    for chunk in range(2):
        rows = np.flatnonzero((PRESS >= PRESSES // 2) == bool(chunk))
        columns = {name: [{"bytes": JPEG[row].tobytes(), "path": None} for row in rows] for name in cameras}
        table = columns | {
            "observation.state": POSES[rows].tolist(),
            "frame_index": rows % 3,
            "episode_index": PRESS[rows],
            "task": ["press the wall"] * len(rows),
        }
        path = (
            folder
            / "data"
            / f"chunk-{chunk:03d}"
            / ("file-000.parquet" if version == 3 else f"episode_{chunk}.parquet")
        )
        path.parent.mkdir(parents=True)
        pyarrow.parquet.write_table(pyarrow.table(table), path)


@pytest.mark.parametrize("version", [2, 3])
def test_lerobot_chunks_with_a_text_column_are_read(version: int, tmp_path: Path) -> None:
    write_lerobot(tmp_path, ("observation.images.tactile",), version)
    recording = read_recording(tmp_path)
    check(recording)
    assert any("task" in note and "text" in note for note in recording.notes)


def test_a_camera_of_lerobot_is_chosen_by_a_flag(tmp_path: Path) -> None:
    cameras = ("observation.images.tactile", "observation.images.wrist")
    write_lerobot(tmp_path, cameras)
    for name in (cameras[0], "tactile"):
        check(read_recording(tmp_path, ColumnMapping(image=name)))
    with refused("recording-several-cameras", *cameras):
        read_recording(tmp_path)


def test_images_of_the_same_names_in_two_folders_are_asked_for(tmp_path: Path) -> None:
    rows = [f"image_{k}.png,{PRESS[k]}," + ",".join(f"{x:.6f}" for x in POSES[k]) for k in range(COUNT)]
    (tmp_path / "targets.csv").write_text("\n".join(["sensor_image,press,rx_deg,ry_deg,depth_mm", *rows]) + "\n")
    (tmp_path / "targets_images.csv").write_bytes((tmp_path / "targets.csv").read_bytes())
    for folder, shown in (("sensor_images", IMAGES), ("processed_images", 255 - IMAGES)):
        (tmp_path / folder).mkdir()
        for k in range(COUNT):
            cv2.imwrite(str(tmp_path / folder / f"image_{k}.png"), shown[k])
    with refused("images-in-several-folders", "processed_images", "sensor_images"):
        read_recording(tmp_path)
    check(read_recording(tmp_path, ColumnMapping(image="sensor_images")))


@pytest.mark.parametrize(
    ("name", "write", "code"),
    [
        (
            "no_images.h5",
            lambda path: h5py.File(path, "w").create_dataset("poses", data=POSES),
            "recording-no-images",
        ),
        (
            "no_poses.h5",
            lambda path: h5py.File(path, "w").create_dataset("images", data=IMAGES),
            "recording-no-table",
        ),
        ("no_images.npz", lambda path: np.savez(path, poses=POSES), "recording-no-images"),
        ("no_poses.npz", lambda path: np.savez(path, images=IMAGES), "recording-no-table"),
        ("pickled.npz", lambda path: np.savez(path, a=np.array([{}], object)), "recording-unreadable"),
        ("torn.npz", lambda path: path.write_bytes(b"PK torn"), "recording-unreadable"),
        ("torn.h5", lambda path: path.write_bytes(b"\x89HDF\r\n\x1a\n"), "recording-unreadable"),
        ("torn.zarr", lambda path: path.mkdir(), "recording-unreadable"),
    ],
)
def test_a_recording_without_its_parts_is_refused(
    name: str, write: Callable[[Path], object], code: str, tmp_path: Path
) -> None:
    write(tmp_path / name)
    with refused(code, name):
        read_recording(tmp_path / name)


def test_a_damaged_chunk_of_a_zarr_store_is_an_error_in_the_place_of_its_image(tmp_path: Path) -> None:
    """The codecs of Zarr have errors of their own kinds."""
    root = zarr.open_group(str(tmp_path / "a.zarr"), mode="w")
    root["images"] = IMAGES[..., 0]
    for name, values in zip(NAMES, POSES.T, strict=True):
        root[name] = values
    chunk = next(path for path in (tmp_path / "a.zarr" / "images" / "c").rglob("*") if path.is_file())
    chunk.write_bytes(b"damaged" + chunk.read_bytes()[7:])
    (image,) = read_recording(tmp_path / "a.zarr").images.read([0])
    assert isinstance(image, PalpateError)
    assert image.code == "image-unreadable"


def test_several_damaged_arrays_of_a_zarr_store_are_one_error(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Zarr opens arrays at the same time; errors after the first would be logged with tracebacks."""
    root = zarr.open_group(str(tmp_path / "a.zarr"), mode="w")
    for number in range(9):
        root[f"array_{number}"] = POSES
        (tmp_path / "a.zarr" / f"array_{number}" / "zarr.json").write_text("damaged")
    with refused("recording-unreadable", "a.zarr"):
        read_recording(tmp_path / "a.zarr")
    time.sleep(0.2)
    gc.collect()
    assert [record for record in caplog.records if record.name == "asyncio"] == []


FIELDS = np.array([tuple(row) for row in POSES], dtype=[(name, float) for name in NAMES])
OTHER_TABLES: dict[str, dict[str, object]] = {
    "fields of one array": {"images": IMAGES, "poses": FIELDS, "press": PRESS},
    "groups": {
        "data/images": IMAGES,
        "data/press": PRESS.astype(str).astype("S"),
        **{f"data/labels/{name}": POSES[:, at] for at, name in enumerate(NAMES)},
        "data/labels/press": PRESS,
    },
}


@pytest.mark.parametrize("kind", OTHER_TABLES)
def test_poses_in_fields_and_in_groups_are_read(kind: str, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, values in OTHER_TABLES[kind].items():
            file[name] = values
    check(read_recording(tmp_path / "a.h5"))


def test_units_of_hdf5_are_read_from_attributes(tmp_path: Path) -> None:
    units = {"rx": (np.pi / 180, "rad"), "ry": (np.pi / 180, b"rad"), "depth": (1e-3, "m")}
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["images"], file["press"] = IMAGES, PRESS
        for at, (name, (factor, unit)) in enumerate(units.items()):
            file[name] = POSES[:, at] * factor
            file[name].attrs["units"] = unit
    check(read_recording(tmp_path / "a.h5"))


def test_masks_are_images(tmp_path: Path) -> None:
    masks = IMAGES[..., 0] > 127
    columns = {name: POSES[:, at] for at, name in enumerate(NAMES)}
    np.savez(tmp_path / "a.npz", images=masks, press=PRESS, **columns)
    (image,) = read_recording(tmp_path / "a.npz").images.read([3])
    assert (np.asarray(image) == 255 * masks[3]).all()


@pytest.mark.parametrize("ending", ["h5", "npz"])
def test_numbers_of_images_and_poses_that_differ_are_said(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{ending}"
    if ending == "h5":
        write_h5(path, IMAGES[1:])
    else:
        np.savez(path, images=IMAGES[1:], poses=POSES)
    with refused("recording-no-table", f"({COUNT - 1}, 20, 24, 3)", f"({COUNT}, 3)"):
        read_recording(path)


DOWN = Rotation.from_euler("x", 180, degrees=True) * Rotation.from_rotvec(
    np.radians([[*row[:2], 0] for row in POSES])
)
QUATERNIONS = Rotation.from_rotvec(np.radians([[*row[:2], 0] for row in POSES])).as_quat()
PLACES = np.column_stack([np.full((COUNT, 2), 400.0), 200.0 - POSES[:, 2]])
WHOLE = [
    np.vstack([np.column_stack([turn, at]), [0, 0, 0, 1]])
    for turn, at in zip(DOWN.as_matrix(), PLACES / 1e3, strict=True)
]
ROBOTS: dict[str, tuple[str, np.ndarray]] = {
    "ABB": ("X,Y,Z,roll,pitch,yaw", np.hstack([PLACES, DOWN.as_euler("xyz", degrees=True)])),
    "KUKA": ("X,Y,Z,A,B,C", np.hstack([PLACES, DOWN.as_euler("ZYX", degrees=True)])),
    "KUKA with units": (
        "X (mm),Y (mm),Z (mm),A (deg),B (deg),C (deg)",
        np.hstack([PLACES, DOWN.as_euler("ZYX", degrees=True)]),
    ),
    "Universal Robots": (
        ",".join(f"actual_TCP_pose_{axis}" for axis in range(6)),
        np.hstack([PLACES / 1e3, DOWN.as_rotvec()]),
    ),
    "robomimic": (
        "robot0_eef_pos_0,robot0_eef_pos_1,robot0_eef_pos_2,"
        + ",".join(f"robot0_eef_quat_{axis}" for axis in "xyzw"),
        np.hstack([PLACES / 1e3, DOWN.as_quat()]),
    ),
    "Franka": (
        ",".join(f"O_T_EE_{at}" for at in range(16)),
        np.stack([matrix.T.ravel() for matrix in WHOLE]),
    ),
    "matrix by rows": (
        ",".join(f"pose[{at}]" for at in range(16)),
        np.stack([matrix.ravel() for matrix in WHOLE]),
    ),
    "topic echo": (
        ",".join(
            [
                *(f"field.pose.position.{axis}" for axis in "xyz"),
                *(f"field.pose.orientation.{axis}" for axis in "xyzw"),
            ]
        ),
        np.hstack([PLACES, DOWN.as_quat()]),
    ),
    "lists of JSON": (
        ",".join(f"tcp_{word}_{axis}" for word in ("position", "rotation") for axis in range(3)),
        np.hstack([PLACES, DOWN.as_rotvec(degrees=True)]),
    ),
    "FANUC": ("X,Y,Z,W,P,R", np.hstack([PLACES, DOWN.as_euler("xyz", degrees=True)])),
}


@pytest.mark.parametrize("robot", ROBOTS)
def test_poses_of_a_robot_without_units_are_relative_to_the_surface(robot: str, tmp_path: Path) -> None:
    names, values = ROBOTS[robot]
    rows = [
        f"{at}.png,{press}," + ",".join(f"{value:.9f}" for value in row)
        for at, press, row in zip(range(COUNT), PRESS, values, strict=True)
    ]
    (tmp_path / "poses.csv").write_text("\n".join([f"image,press,{names}", *rows]))
    for at, image in enumerate(IMAGES):
        cv2.imwrite(str(tmp_path / f"{at}.png"), image)
    flags = {"lists of JSON": ColumnMapping(euler="rotvec", angles="deg")}
    recording = read_recording(tmp_path, flags.get(robot))
    assert [f"{one.axis}_{one.unit}" for one in recording.poses] == list(NAMES)
    wanted = POSES - [0, 0, POSES[:, 2].min()]  # the depth of positions begins at the shallowest
    assert recording.targets == pytest.approx(wanted, abs=1e-5)


def test_a_tool_of_a_robot_that_is_turned_by_less_than_90_degrees_is_relative_to_the_surface() -> None:
    """Its numbers are a rotation vector by their name, and its mean axis is the normal, not the axis of the base."""
    upright = Rotation.from_euler("y", 55, degrees=True)
    tilts = np.vstack([POSES[:, :2], -POSES[:, :2]])
    turns = upright * Rotation.from_rotvec(np.radians(np.column_stack([tilts, np.zeros(2 * COUNT)])))
    places = np.repeat(PLACES[:1], 2 * COUNT, axis=0) + np.tile(POSES[:, 2:], (2, 1)) * upright.as_matrix()[:, 2]
    values = np.hstack([places / 1e3, turns.as_rotvec()])
    columns = {f"actual_TCP_pose_{at}": values[:, at] for at in range(6)}
    found = to_surface(RecordingTable("a.csv", columns, {}), ColumnMapping(), ()).columns
    tilt = np.hypot(found["rx_deg"], found["ry_deg"])
    assert tilt == pytest.approx(np.hypot(*tilts.T), abs=0.1)
    assert found["depth_mm"] == pytest.approx(np.tile(POSES[:, 2] - POSES[:, 2].min(), 2), abs=0.1)


@pytest.mark.parametrize("kind", ["rotvec", "xyzw", "matrix", "ZYX"])
def test_a_flag_of_an_orientation_without_its_columns_is_refused(kind: str) -> None:
    table = RecordingTable("a.csv", {"x_mm": PLACES[:, 0], "aim_3": PLACES[:, 1]}, {})
    with refused("euler-columns-missing", kind, "aim_3"):
        to_surface(table, ColumnMapping(euler=kind), ())
    small = RecordingTable("a.csv", {"rx": POSES[:, 0] / 9, "ry": POSES[:, 1] / 9}, {})
    with refused("column-unit-unknown", "rx"):
        to_surface(small, ColumnMapping(euler="rotvec"), ())


@pytest.mark.parametrize(
    "labels", [("rx_deg", "ry_deg", "depth_mm"), ("z_mm",), ("X", "Y", "Z"), ("roll_deg", "pitch_deg", "z_mm")]
)
@pytest.mark.parametrize("first", [False, True])
def test_labels_beside_the_columns_of_a_robot_are_kept(labels: tuple[str, ...], first: bool) -> None:
    rows = np.hstack([PLACES / 1e3, DOWN.as_rotvec()]).T
    robot = {f"actual_TCP_pose_{axis}": rows[axis] for axis in range(6)}
    own = {name: np.linspace(0, 5, len(PLACES)) for name in labels}
    table = RecordingTable("a", own | robot if first else robot | own, {})
    found = to_surface(table, ColumnMapping(), ())
    assert found.columns.keys() == table.columns.keys()


def test_a_height_alone_in_a_base_is_refused_and_targets_keep_their_unit(tmp_path: Path) -> None:
    for at, image in enumerate(IMAGES):
        cv2.imwrite(str(tmp_path / f"{at}.png"), image)
    rows = [f"{at}.png,{PRESS[at]},{a / 57.29577951:.6f},{b},{c}" for at, (a, b, c) in enumerate(POSES)]
    (tmp_path / "poses.csv").write_text("\n".join(["image,press,tilt a [rad],ry_deg,z_mm", *rows]))
    found = read_recording(tmp_path, ColumnMapping(targets=("tilt a=rx", "ry_deg", "z_mm")))
    assert found.targets == pytest.approx(POSES, abs=1e-3)
    with refused("positions-missing", "z_mm"):
        read_recording(tmp_path, ColumnMapping(frame="0,0,200,0,0,1"))


def test_a_position_in_a_base_without_an_orientation_keeps_its_name() -> None:
    names = [f"robot0_eef_pos_{axis}" for axis in range(3)]
    table = RecordingTable("a", dict(zip(names, PLACES.T, strict=True)), {})
    assert list(to_surface(table, ColumnMapping(), ()).columns) == names


@pytest.mark.parametrize(
    "columns",
    [
        {
            "tilt": POSES[:, 0] + 20,
            "rx": np.pi - 0.01 * POSES[:, 0] ** 2,
            "ry": 0.03 * POSES[:, 1],
            "rz": POSES[:, 0] / 90,
        },
        {
            "rx_deg": POSES[:, 0],
            "ry_deg": POSES[:, 1],
            "height": np.linspace(480, 490, COUNT),
            "depth": POSES[:, 2] / 1e4,
        },
        {"rx_deg": POSES[:, 0], "ry_deg": POSES[:, 1], "x": POSES[:, 0] / 900, "depth": POSES[:, 2]},
    ],
)
def test_a_unit_that_only_another_column_hints_at_is_asked_for(
    columns: dict[str, np.ndarray], tmp_path: Path
) -> None:
    rows = [
        f"{at}.png,{press}," + ",".join(f"{values[at]:.6f}" for values in columns.values())
        for at, press in enumerate(PRESS)
    ]
    (tmp_path / "poses.csv").write_text("\n".join(["image,press," + ",".join(columns), *rows]))
    for at, image in enumerate(IMAGES):
        cv2.imwrite(str(tmp_path / f"{at}.png"), image)
    with refused("column-unit-unknown", "names no unit"):
        read_recording(tmp_path)


@pytest.mark.parametrize("names", ["x,y,z,a (N),b (N),c (N)", "x,y,z,w,p,r", "X,Y,Z,A (N),B (N),C (N)"])
def test_letters_that_are_no_angles_of_a_robot_keep_their_names(names: str, tmp_path: Path) -> None:
    table = RecordingTable("t", {name: 3.0 * POSES[:, at % 3] for at, name in enumerate(names.split(","))}, {})
    assert set(to_surface(table, ColumnMapping(), ()).columns) == set(names.split(","))
