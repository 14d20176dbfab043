"""Columns of a table in memory: units by their definitions, limits from both sides, tilts by scipy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from errors import refused
from palpate.datasets import ColumnMapping, RecordingTable
from palpate.datasets.pose_column import with_unit
from palpate.datasets.quantities import find_quantities
from palpate.datasets.read_forces import find_times
from palpate.datasets.recording_columns import (
    find_gaps,
    find_image_column,
    find_pose_columns,
    find_press_column,
)
from palpate.datasets.surface_poses import to_surface

COUNT = 20
WAVE = np.sin(1.7 * np.arange(COUNT))
PLAIN = ColumnMapping()


def table(columns: dict[str, object], faults: dict[str, str] | None = None) -> RecordingTable:
    values = {name: np.asarray(value) for name, value in columns.items()}
    return RecordingTable(
        "t.csv", {k: v.astype(float) if v.dtype.kind in "if" else v for k, v in values.items()}, faults or {}
    )


def learn(columns: dict[str, object], taken: tuple[str, ...] = (), **choice: object) -> tuple:
    return find_pose_columns(table(columns), ColumnMapping(**choice), taken)  # type: ignore[arg-type]


G = 9.80665
POUND = 0.45359237


@pytest.mark.parametrize(
    ("name", "axis", "unit", "one"),
    [
        ("rx_deg", "rx", "deg", 1.0),
        ("rx (rad)", "rx", "deg", 360.0 / (2 * np.pi)),
        ("ry_mrad", "ry", "deg", 0.36 / (2 * np.pi)),
        ("depth_um", "depth", "mm", 0.001),
        ("depth [cm]", "depth", "mm", 10.0),
        ("depth_m", "depth", "mm", 1000.0),
        ("depth_inch", "depth", "mm", 25.4),
        ("fz_N", "force", "N", 1.0),
        ("fz_mN", "force", "N", 0.001),
        ("fz_kN", "force", "N", 1000.0),
        ("fz_gf", "force", "N", 0.001 * G),
        ("fz_kgf", "force", "N", G),
        ("fz_lbf", "force", "N", POUND * G),
        ("mz_Nm", "mz", "Nm", 1.0),
        ("mz_Nmm", "mz", "Nm", 0.001),
    ],
)
def test_a_unit_in_a_name_converts_to_degrees_millimetres_and_newtons(
    name: str, axis: str, unit: str, one: float
) -> None:
    (found,), _, _ = learn({name: WAVE})
    assert (found.axis, found.unit, found.column) == (axis, unit, name)
    assert found.values == pytest.approx(one * WAVE)


@pytest.mark.parametrize(
    ("name", "most", "unit"),
    [("angle", 3.6, "deg"), ("depth", 0.36, "mm"), ("angle", 3.4, ""), ("depth", 0.34, "")],
)
def test_a_column_without_a_unit_is_read_by_its_values_or_refused(name: str, most: float, unit: str) -> None:
    values = np.linspace(-most, most, COUNT)
    if unit:
        found = with_unit(table({name: values}), name, PLAIN)
        assert (found.unit, found.values.tolist()) == (unit, values.tolist())
        assert "no unit" in found.note
    else:
        with refused("column-unit-unknown", name, f"{most:.3g}"):
            with_unit(table({name: values}), name, PLAIN)
        flag = {"angles": "rad"} if name == "angle" else {"lengths": "m"}
        stated = with_unit(table({name: values}), name, ColumnMapping(**flag))
        assert stated.values == pytest.approx(np.degrees(values) if name == "angle" else 1000 * values)
        assert stated.note == ""


def test_a_quantity_without_a_known_unit_is_kept_as_it_stands() -> None:
    values = 7.0 * WAVE
    assert with_unit(table({"rx [1/s]": values}), "rx [1/s]", PLAIN).unit == "1"
    other = with_unit(table({"grip": values}), "grip", PLAIN)
    assert (other.unit, other.axis, other.values.tolist()) == ("1", "grip", values.tolist())


def test_of_two_columns_that_name_images_one_must_be_chosen() -> None:
    names = [f"{k}.png" for k in range(3)]
    both = table({"left": names, "right": names, "rx_deg": [1, 2, 3]})
    with refused("column-ambiguous", "left", "right"):
        find_image_column(both, PLAIN)
    assert find_image_column(both, ColumnMapping(image="right")) == "right"
    assert find_image_column(table({"left": names, "image": names}), PLAIN) == "image"
    assert find_image_column(table({"frame": [0, 1, 2], "file": ["a", "b", "c"]}), PLAIN) == "frame"
    with refused("image-column-missing"):
        find_image_column(table({"rx_deg": [1, 2, 3]}), PLAIN)


def test_the_column_of_the_press_is_known_by_its_name_or_chosen() -> None:
    both = table({"rx_deg": [1, 2], "Trial": [0, 0], "other": [1, 1]})
    assert find_press_column(both, PLAIN) == "Trial"
    assert find_press_column(both, ColumnMapping(press="other")) == "other"
    assert find_press_column(table({"rx_deg": [1, 2]}), PLAIN) == ""
    with refused("column-unknown", "none"):
        find_press_column(both, ColumnMapping(press="none"))


@pytest.mark.parametrize("name", ["depth_mm", ""])
def test_a_column_is_not_given_the_name_of_another_nor_none(name: str) -> None:
    with refused("column-name-reserved", name):
        learn({"pose_4": WAVE, "depth_mm": 2 * WAVE}, targets=(f"pose_4={name}",))


def test_a_renamed_column_keeps_the_unit_of_its_old_name() -> None:
    poses, _, _ = learn({"a [rad]": WAVE, "b_mm": WAVE}, targets=("a [rad]=rx", "b_mm=depth"))
    assert [(one.axis, one.unit) for one in poses] == [("rx", "deg"), ("depth", "mm")]
    assert poses[0].values == pytest.approx(np.degrees(WAVE))


@pytest.mark.parametrize(("gap", "continued"), [(44.0, False), (46.0, True)])
def test_an_angle_is_continued_over_180_degrees_if_its_circle_opens(gap: float, continued: bool) -> None:
    """Angles that fill the circle but for a gap at 30°."""
    true = np.linspace(30 + gap / 2, 390 - gap / 2, 400)
    assert np.diff(true).max() < 1
    turned = (true + 180) % 360 - 180
    if not continued:
        for targets in ((), ("rx_deg",)):
            with refused("angle-jumps", "rx_deg"):
                learn({"rx_deg": turned, "depth_mm": true}, targets=targets)
        poses, _, left = learn({"rz_deg": turned, "depth_mm": true})
        assert [one.axis for one in poses] == ["depth"]
        assert any("rz_deg" in text for text in left)
    else:
        poses, _, _ = learn({"rx_deg": turned, "depth_mm": true})
        assert np.abs(np.diff(poses[0].values)).max() < 1
        assert (poses[0].values - true) % 360 == pytest.approx(np.zeros(400), abs=1e-9) or np.ptp(
            poses[0].values - true
        ) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("missing", "left_out"), [(1, 1), (2, 2), (3, 0)])
def test_rows_without_a_number_are_left_out_up_to_a_tenth(missing: int, left_out: int) -> None:
    values = 10 * WAVE
    values[:missing] = np.nan
    gaps, said = find_gaps(table({"rx_deg": values, "other": values, "ry_deg": WAVE}), PLAIN)
    assert gaps.tolist() == [k < left_out for k in range(COUNT)]
    assert (f"{left_out} of {COUNT}" in said and "rx_deg" in said) if left_out else said == ""
    chosen, _ = find_gaps(table({"rx_deg": values, "ry_deg": WAVE}), ColumnMapping(targets=("ry_deg",)))
    assert not chosen.any()


@pytest.mark.parametrize(
    ("column", "why"),
    [
        (np.full(COUNT, 3.0), "3 throughout"),
        (np.full(COUNT, 1e6) + 1e-4 * WAVE, "throughout"),
        (np.arange(5.0, 5.0 + COUNT), "counts"),
        (np.where(np.arange(COUNT) == 4, np.nan, WAVE), f"1 of its {COUNT}"),
        (np.array(["a"] * COUNT), "text"),
    ],
)
def test_a_column_that_says_nothing_is_left_out_with_its_reason(column: np.ndarray, why: str) -> None:
    poses, _, left = learn({"grip_mm": column, "rx_deg": 20 * WAVE, "depth_mm": 3 * WAVE})
    assert [one.axis for one in poses] == ["rx", "depth"]
    assert len(left) == 1
    assert why in left[0]


def test_quantities_of_axes_are_found_or_refused_with_the_reason() -> None:
    good = {"Rx [rad]": WAVE, "ry_deg": WAVE, "depth_m": WAVE}
    found = find_quantities(table(good), PLAIN, (), ("rx", "depth"), ("ry", "fz"))
    assert list(found) == ["rx", "depth", "ry"]
    assert found["rx"].values == pytest.approx(np.degrees(WAVE))
    with refused("column-missing", "ry"):
        find_quantities(table(good), PLAIN, ("ry_deg",), ("rx", "ry"))
    with refused("value-not-number", "ry_deg", "x"):
        find_quantities(table({**good, "ry_deg": ["x"] * COUNT}), PLAIN, (), ("rx", "ry"))
    with refused("value-not-number", "ry_deg", "line 7"):
        find_quantities(table(good, {"ry_deg": "line 7 has 'x'"}), PLAIN, (), ("rx", "ry"))
    with refused("column-unit-unknown", "ry"):
        find_quantities(table({"rx_deg": WAVE, "ry": WAVE}), PLAIN, (), ("rx", "ry"))
    assert list(find_quantities(table({"rx_deg": WAVE, "ry": WAVE}), PLAIN, (), ("rx",))) == ["rx"]


EPOCH_S = 1.7e9


@pytest.mark.parametrize(
    ("name", "scale", "choice"),
    [
        ("time_ms", 1e3, ""),
        ("t [us]", 1e6, ""),
        ("stamp (ns)", 1e9, ""),
        ("time", 1e3, "ms"),
        ("timestamp", 1.0, ""),
        ("timestamp", 1e3, ""),
        ("timestamp", 1e6, ""),
        ("timestamp", 1e9, ""),
    ],
)
def test_times_are_seconds_by_name_flag_or_epoch(name: str, scale: float, choice: str) -> None:
    start = EPOCH_S if name == "timestamp" else 0.0
    seconds = start + 0.25 * np.arange(8)
    column, found = find_times(table({"rx_deg": WAVE[:8], name: scale * seconds}), ColumnMapping(times=choice))
    assert column == name
    assert found == pytest.approx(seconds, abs=1e-4)


def test_steps_of_half_a_second_without_a_unit_may_be_milliseconds() -> None:
    assert find_times(table({"time": 0.49 * np.arange(8)}), PLAIN)[1] == pytest.approx(0.49 * np.arange(8))
    with refused("time-unit-unknown", "time", "0.5"):
        find_times(table({"time": 0.5 * np.arange(8)}), PLAIN)
    with refused("time-column-missing", "rx_deg"):
        find_times(table({"rx_deg": WAVE}), PLAIN)


TILTS = np.random.default_rng(1).uniform(-12, 12, (COUNT, 2))
"""Rotation vectors of tilts, degrees."""
DEPTHS = np.linspace(1.0, 4.0, COUNT)


def tool(down: bool = True) -> tuple[Rotation, np.ndarray]:
    """Orientations and places, mm, of a tool that presses a table at z = 150 mm with these tilts and depths."""
    tilt = Rotation.from_rotvec(np.column_stack([TILTS, np.zeros(COUNT)]), degrees=True)
    base = Rotation.from_euler("x", 180.0 if down else 0.0, degrees=True)
    spin = Rotation.from_euler("z", 25.0, degrees=True)
    places = np.column_stack([400.0 + 0.1 * np.arange(COUNT), np.full(COUNT, -100.0), 150.0 - DEPTHS])
    return base * spin * tilt, places


@pytest.mark.parametrize("kind", ["xyzw", "wxyz", "rotvec", "xyz", "ZYX", "matrix"])
def test_the_tilt_of_a_tool_that_points_down_does_not_depend_on_how_it_is_written(kind: str) -> None:
    turns, places = tool()
    columns: dict[str, object] = dict(zip(("x_mm", "y_mm", "z_mm"), places.T, strict=True))
    if kind in ("xyzw", "wxyz"):
        quaternion = turns.as_quat()[:, [3, 0, 1, 2]] if kind == "wxyz" else turns.as_quat()
        columns |= dict(zip((f"q{k}" for k in range(4)), quaternion.T, strict=True))
    elif kind == "matrix":
        columns |= {f"r{i + 1}{j + 1}": turns.as_matrix()[:, i, j] for i in range(3) for j in range(3)}
    else:
        values = turns.as_rotvec(degrees=True) if kind == "rotvec" else turns.as_euler(kind, degrees=True)
        order = {letter: k for k, letter in enumerate(kind.lower())} if kind != "rotvec" else {"x": 0, "y": 1, "z": 2}
        columns |= {f"r{letter}_deg": values[:, order[letter]] for letter in "xyz"}
    said = ColumnMapping(euler="" if kind == "matrix" else kind, frame="0,0,150,0,0,2")
    found = to_surface(table(columns), said, ()).columns
    assert found["depth_mm"] == pytest.approx(DEPTHS, abs=1e-9)
    size = np.linalg.norm(TILTS, axis=1)
    assert np.hypot(found["rx_deg"], found["ry_deg"]) == pytest.approx(size, abs=1e-6)
    ours, theirs = (
        np.unwrap(np.arctan2(y, x)) for x, y in ((found["rx_deg"], found["ry_deg"]), (TILTS[:, 0], TILTS[:, 1]))
    )
    apart = np.exp(1j * (ours - theirs))
    assert apart == pytest.approx(np.full(COUNT, apart[0]), abs=1e-6), "the same axis, turned as a whole"
    assert found["rx_deg"] == pytest.approx(TILTS[:, 0], abs=1e-6)
    assert found["ry_deg"] == pytest.approx(TILTS[:, 1], abs=1e-6)


def test_an_orientation_that_is_named_must_be_there() -> None:
    with refused("euler-columns-missing", "xyz"):
        to_surface(table({"depth_mm": DEPTHS}), ColumnMapping(euler="xyz"), ())
    with refused("euler-order-unknown", "xxy"):
        to_surface(table({"rx_deg": WAVE, "ry_deg": WAVE, "rz_deg": WAVE}), ColumnMapping(euler="xxy"), ())
    with refused("orientation-unknown", "q0"):
        turns = tool()[0].as_quat()
        to_surface(table(dict(zip(("q0", "q1", "q2", "q3"), turns.T, strict=True))), PLAIN, ())


@pytest.mark.parametrize("frame", ["1,2,3,0,0", "1,2,3,0,0,0", "1,2,3,0,0,nan", "a,2,3,0,0,1", "1,2,3,0,0,1,1"])
def test_a_frame_is_a_point_and_a_normal(frame: str) -> None:
    with refused("frame-unreadable", frame):
        to_surface(table({"depth_mm": DEPTHS}), ColumnMapping(frame=frame), ())


def test_a_frame_with_a_height_needs_the_other_two_lengths() -> None:
    frame = ColumnMapping(frame="0,0,150,0,0,1")
    with refused("positions-missing", "z_mm"):
        to_surface(table({"z_mm": 150 - DEPTHS, "rx_deg": WAVE, "ry_deg": WAVE}), frame, ())
    columns = {"x_mm": DEPTHS, "y_mm": DEPTHS, "z_mm": 150 - DEPTHS}
    assert to_surface(table(columns), frame, ()).columns["depth_mm"] == pytest.approx(DEPTHS)


def test_the_depth_under_a_leaning_surface_is_along_its_normal() -> None:
    normal = np.array([0.0, 3.0, 4.0])
    places = np.array([10.0, 20.0, 150.0]) - DEPTHS[:, None] * normal / 5.0
    columns = dict(zip(("x_mm", "y_mm", "z_mm"), places.T, strict=True))
    frame = ColumnMapping(frame=",".join(map(str, (10, 20, 150, *normal))))
    assert to_surface(table(columns), frame, ()).columns["depth_mm"] == pytest.approx(DEPTHS)


@pytest.mark.parametrize("axis", ["-z", "+x", "-x", "-y"])
def test_the_surface_is_normal_to_the_base_axis_nearest_to_the_tools(axis: str) -> None:
    """The mean of evenly spread tilts is the tool's axis; the depth counts from the shallowest image."""
    azimuth = 2 * np.pi * np.arange(COUNT) / COUNT
    tilts = 10.0 * np.column_stack([np.cos(azimuth), np.sin(azimuth), np.zeros(COUNT)])
    into = (1.0 if axis[0] == "+" else -1.0) * np.eye(3)["xyz".index(axis[1])]
    base = Rotation.align_vectors([into, np.roll(into, 1)], [[0, 0, 1], [1, 0, 0]])[0]
    turns = base * Rotation.from_rotvec(tilts, degrees=True)
    places = np.array([400.0, -100.0, 150.0]) + DEPTHS[:, None] * into
    columns = dict(zip(("x_mm", "y_mm", "z_mm"), places.T, strict=True))
    columns |= dict(zip(("qx", "qy", "qz", "qw"), turns.as_quat().T, strict=True))
    found = to_surface(table(columns), PLAIN, ())
    assert found.columns["depth_mm"] == pytest.approx(DEPTHS - DEPTHS[0])
    assert np.hypot(found.columns["rx_deg"], found.columns["ry_deg"]) == pytest.approx(np.full(COUNT, 10.0))
    assert any(f"normal to {axis}" in note for note in found.notes)


def test_tools_that_point_everywhere_press_no_surface() -> None:
    turns = Rotation.from_rotvec(np.column_stack([np.linspace(0, 178, COUNT), *np.zeros((2, COUNT))]), degrees=True)
    with refused("orientation-spread", "quaternion"):
        to_surface(table(dict(zip(("qx", "qy", "qz", "qw"), turns.as_quat().T, strict=True))), PLAIN, ())


def test_a_column_that_cannot_be_learnt_is_refused_if_it_is_asked_for() -> None:
    with refused("column-not-trainable", "grip_mm", "3 throughout"):
        learn({"grip_mm": np.full(COUNT, 3.0), "rx_deg": WAVE}, targets=("grip_mm",))
    with refused("columns-none", "t.csv"):
        learn({"grip_mm": np.full(COUNT, 3.0)})
    with refused("column-unit-unknown", "rx", "depth"):
        learn({"rx": WAVE, "depth": 0.1 * WAVE, "ry_deg": WAVE})
    poses, _, left = learn({"rx": WAVE, "ry_deg": WAVE}, targets=("ry_deg",))
    assert [one.axis for one in poses] == ["ry"]
    assert any("rx" in text for text in left)


def test_gaps_count_in_a_column_that_is_asked_for_by_its_new_name() -> None:
    values = 10 * WAVE
    values[0] = np.nan
    gaps, _ = find_gaps(table({"pose_4": values, "rx_deg": WAVE}), ColumnMapping(targets=("pose_4=rx_deg",)))
    assert gaps.sum() == 1
