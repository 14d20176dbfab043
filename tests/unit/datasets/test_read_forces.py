"""Forces of a sensor with its own clock and rate at the times of the images of a recording."""

from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np
import pytest
from test_recording_tables import write_csv, write_images

from errors import refused
from palpate.datasets import ColumnMapping, Recording, read_recording

COUNT = 64
START = 1_700_000_000.0
SIZE = np.array([3.0, 2.0, 8.0, 0.05, 0.04, 0.03])
IMAGES_S = START + 0.5 + np.arange(COUNT) / 30
TIMES_S = START + np.arange(3500) / 1000


def wrench(time: np.ndarray) -> np.ndarray:
    """(n, 6) N and N m of a smooth press."""
    return SIZE * np.sin(2 * np.pi * np.outer(time - START, [0.3, 0.5, 0.4, 0.6, 0.2, 0.7]))


def write_recording(folder: Path, clock: str = "timestamp", factor: float = 1.0, start: float = START) -> Path:
    names, poses = write_images(folder / "images", COUNT), 9 * np.sin(1.7 * np.arange(COUNT))
    times = (IMAGES_S - START + start) * factor
    rows = [f"{names[k]},{times[k]:.6f},{k // 4},{poses[k]:.4f},{poses[-k]:.4f},{2 + k / 40}" for k in range(COUNT)]
    return write_csv(folder, f"image,{clock},press,rx_deg,ry_deg,depth_mm", rows)


def write_forces(path: Path, head: str, values: np.ndarray, times: np.ndarray) -> Path:
    rows = [
        ",".join([f"{time:.6f}", *(f"{value:.9g}" for value in row)]) for time, row in zip(times, values, strict=True)
    ]
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def read(folder: Path, forces: Path, **choice: str) -> Recording:
    return read_recording(folder / "poses.csv", ColumnMapping(forces=forces, **choice))  # type: ignore[arg-type]


def values(found: Recording) -> dict[str, np.ndarray]:
    return {f"{one.axis}_{one.unit}": one.values for one in found.others}


@pytest.mark.parametrize(
    ("head", "scale", "choice"),
    [
        ("time_s,Fx_N,Fy_N,Fz_N,Tx_Nm,Ty_Nm,Tz_Nm", np.ones(6), {}),
        ("Time,Fx (mN),Fy (mN),Fz (mN),Tx (N-mm),Ty (N-mm),Tz (N-mm)", np.full(6, 1e3), {}),
        ("Time,Fx_mN,Fy_mN,Fz_mN,Tx_mNm,Ty_mNm,Tz_mNm", np.full(6, 1e3), {}),
        ("t,force.x,force.y,force.z,torque.x,torque.y,torque.z", np.ones(6), {"force_unit": "N"}),
    ],
)
def test_forces_of_1_khz_are_those_of_the_times_of_images(
    tmp_path: Path, head: str, scale: np.ndarray, choice: dict[str, str]
) -> None:
    write_recording(tmp_path)
    forces = write_forces(tmp_path / "ft.txt", head, wrench(TIMES_S) * scale, TIMES_S)
    found = values(read(tmp_path, forces, **choice))
    assert "time_1" not in found
    names = ("fx_N", "fy_N", "force_N", "tx_Nm", "ty_Nm", "tz_Nm")
    assert np.column_stack([found[name] for name in names]) == pytest.approx(wrench(IMAGES_S), abs=1e-3)


def test_times_have_the_unit_of_their_name_or_flag(tmp_path: Path) -> None:
    write_recording(tmp_path, "timestamp_ms", 1e3, 0.0)
    forces = write_forces(tmp_path / "ft.txt", "time_us,Fz_N", wrench(TIMES_S)[:, 2:3], (TIMES_S - START) * 1e6)
    assert values(read(tmp_path, forces))["force_N"] == pytest.approx(wrench(IMAGES_S)[:, 2], abs=1e-3)
    forces = write_forces(tmp_path / "ft.txt", "time,Fz_N", wrench(TIMES_S)[:, 2:3], (TIMES_S - START) * 1e3)
    with refused("time-unit-unknown", "time", "ft.txt", "--times"):
        read(tmp_path, forces)
    assert values(read(tmp_path, forces, times="ms"))["force_N"] == pytest.approx(wrench(IMAGES_S)[:, 2], abs=1e-3)


@pytest.mark.parametrize("zone", ["", "Z", "+02:00"])
def test_times_may_be_dates(zone: str, tmp_path: Path) -> None:
    write_recording(tmp_path)
    shift = {"": 0, "Z": 0, "+02:00": 7200}[zone]
    dates = [
        datetime.fromtimestamp(1.7e9 + shift + time, UTC).replace(tzinfo=None).isoformat() + zone
        for time in TIMES_S - START
    ]
    rows = [f"{date},{force:.6f}" for date, force in zip(dates, wrench(TIMES_S)[:, 2], strict=True)]
    (tmp_path / "ft.csv").write_text("\n".join(["time,Fz_N", *rows]))
    found = values(read(tmp_path, tmp_path / "ft.csv"))
    assert found["force_N"] == pytest.approx(wrench(IMAGES_S)[:, 2], abs=1e-3)


def test_images_without_a_force_at_their_time_are_left_out(tmp_path: Path) -> None:
    write_recording(tmp_path)
    forces = write_forces(tmp_path / "ft.txt", "time_s,Fz_N", wrench(TIMES_S)[:2000, 2:3], TIMES_S[:2000])
    found = read(tmp_path, forces)
    kept = TIMES_S[1999] >= IMAGES_S
    assert len(found) == kept.sum() < COUNT
    assert values(found)["force_N"] == pytest.approx(wrench(IMAGES_S[kept])[:, 2], abs=1e-3)
    assert found.names[-1] == f"{kept.sum() - 1:03d}.png"
    assert any(f"{(~kept).sum()} of {COUNT} images" in note for note in found.notes)


def test_forces_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    write_recording(tmp_path, start=100.0)
    forces, one = tmp_path / "ft.txt", wrench(TIMES_S)[:, 2:3]
    write_forces(forces, "time_s,Fz_N", one, TIMES_S - START)
    with refused("forces-no-overlap", "0.000 to 3.499", "100.500 to 102.600"):
        read(tmp_path, forces)
    with refused("time-column-missing", "ft.txt", "Fz_N"):
        read(tmp_path, write_forces(forces, "sample,Fz_N", one, TIMES_S))
    with refused("force-columns-missing", "voltage"):
        read(tmp_path, write_forces(forces, "time_s,voltage", one, TIMES_S))
    with refused("force-unit-unknown", "Fz", "--force-unit"):
        read(tmp_path, write_forces(forces, "time_s,Fz", one, TIMES_S))
    write_recording(tmp_path, "number")
    with refused("time-column-missing", "poses.csv"):
        read(tmp_path, write_forces(forces, "time_s,Fz_N", one, TIMES_S))


def test_a_clock_that_is_late_is_corrected_and_reported(tmp_path: Path) -> None:
    """Images of a camera whose clock is 0.2 s late: their grey level follows the force."""
    write_recording(tmp_path, start=START + 0.2)
    for number, force in enumerate(fast(IMAGES_S)):
        image = np.full((16, 16), 128 + 100 * force)
        cv2.imwrite(str(tmp_path / "images" / f"{number:03d}.png"), np.rint(image).astype(np.uint8))
    forces = write_forces(tmp_path / "ft.txt", "time_s,Fz_N", fast(TIMES_S)[:, None], TIMES_S)
    found = read(tmp_path, forces)
    assert values(found)["force_N"] == pytest.approx(fast(IMAGES_S), abs=0.05)
    assert any("200 ms later" in note or "199 ms later" in note or "201 ms later" in note for note in found.notes)


def fast(time: np.ndarray) -> np.ndarray:
    """(n,) N, with changes of speed that mark a time."""
    return np.sin(2 * np.pi * (time - START) + np.sin(7 * (time - START)))


def test_times_of_images_that_begin_again_are_refused(tmp_path: Path) -> None:
    path = write_recording(tmp_path)
    head, *rows = path.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    for number in range(8):
        cells[40 + number][1] = cells[number][1]
    path.write_text("\n".join([head, *(",".join(row) for row in cells)]) + "\n")
    forces = write_forces(tmp_path / "ft.csv", "time_s,Fz_N", wrench(TIMES_S)[:, 2:3], TIMES_S)
    with refused("times-restart", "poses.csv", 41):
        read(tmp_path, forces)
