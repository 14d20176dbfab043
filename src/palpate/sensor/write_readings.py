"""Readings as CSV, JSON lines or a rosbag2."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from palpate.core import PalpateError, wrap_write_errors
from palpate.core.report import CsvWriter
from palpate.design import TILT_SPACE, PoseSpace
from palpate.sensor.reading import Reading
from palpate.sensor.write_bag import write_bag

KINDS = (".csv", ".jsonl", ".rosbag2")
"""Suffixes of the files that readings can be written to."""

_FORCE = (
    "normal_force_n",
    "normal_force_half_width_n",
    "tangential_force_n",
    "tangential_force_half_width_n",
    "friction",
    "curvature_per_m",
    "curvature_sd_per_m",
)
"""Empty if not estimated."""
_STATE = ("touching", "inverted", "found", "flags", "rest_moved_px", "latency_ms", "reason")


def reading_columns(space: PoseSpace) -> tuple[str, ...]:
    """Return the columns of readings whose poses are of a space."""
    return ("image", *space.names, *space.half_width_names, *_FORCE, *_STATE)


def describe_reading(reading: Reading) -> dict[str, Any]:
    """Return a reading as plain data by `reading_columns`; numbers that are not finite become `None`."""
    values = (
        reading.image,
        *reading.pose.tolist(),
        *reading.half_width.tolist(),
        *_forces(reading),
        reading.touching,
        reading.fit.inverted if reading.fit is not None and reading.touching else None,
        reading.found,
        "; ".join(reading.flags),
        reading.rest.rms_px if reading.rest is not None else math.nan,
        reading.latency_ms,
        reading.reason,
    )
    finite = (None if isinstance(value, float) and not math.isfinite(value) else value for value in values)
    return dict(zip(reading_columns(reading.space), finite, strict=True))


def _forces(reading: Reading) -> tuple[float, ...]:
    """Return values by `_FORCE`, NaN if unknown; the half-widths cover 90 %."""
    if reading.force is None or not reading.touching:
        return (math.nan,) * len(_FORCE)
    normal, tangential = reading.force.normal_force, reading.force.tangential_force
    friction = (
        1.0 / reading.fit.inverse_friction.value
        if reading.fit is not None and reading.fit.inverse_friction.value > 0
        else math.nan
    )
    bend = reading.fit.curvature if reading.fit and reading.fit.curvature.sd > 0 else (math.nan, math.nan)
    return normal.value, normal.half_width, tangential.value, tangential.half_width, friction, *bend


def write_readings(path: Path, readings: Iterable[Reading], space: PoseSpace = TILT_SPACE) -> Iterator[Reading]:
    """Write readings as they arrive, and yield them, to a .csv or .jsonl file or a new .rosbag2 folder.

    Raises
    ------
    PalpateError
        If the file is of another kind or cannot be written.
    MissingExtraError
        If rosbags is not installed and a bag is asked for.
    """
    if path.suffix not in KINDS:
        raise PalpateError(
            f"{path.name} is neither {', '.join(KINDS[:-1])} nor {KINDS[-1]}.",
            "Choose one of these suffixes.",
            code="file-ending-unknown",
        )
    if path.suffix == ".rosbag2":
        return write_bag(path, ((reading, describe_reading(reading)) for reading in readings))
    return _write_text(path, readings, reading_columns(space))


def _write_text(path: Path, readings: Iterable[Reading], columns: tuple[str, ...]) -> Iterator[Reading]:
    with wrap_write_errors(path), path.open("w", newline="", encoding="utf-8") as file:
        table = CsvWriter(file, columns) if path.suffix == ".csv" else None
        for reading in readings:
            row = describe_reading(reading)
            if table is not None:
                table.write(row)
            else:
                file.write(json.dumps(row) + "\n")
            file.flush()
            yield reading
