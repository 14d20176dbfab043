"""LeRobot datasets, versions 2 and 3: Parquet tables and videos; each episode is a press.

The files are read by pyarrow; LeRobot itself is not needed.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from palpate.camera import decode_image, read_image
from palpate.core import PalpateError, load_extra
from palpate.datasets.recording_images import ImageSet, SeparateImages, VideoImages
from palpate.datasets.recording_reader import RecordingReader, reading
from palpate.datasets.table import Column, RecordingTable

_REMEDY = "Give the folder that holds meta/info.json, data and videos."


@final
class LeRobotReader(RecordingReader):
    """Datasets of LeRobot; reading needs pyarrow."""

    formats = "LeRobot datasets"

    @classmethod
    def accepts(cls, place: Path) -> bool:
        return (place / "meta" / "info.json").is_file()

    def read(self, place: Path) -> tuple[RecordingTable, ImageSet]:
        parquet = load_extra("pyarrow.parquet", "parquet", "pyarrow")
        with reading(place.name, _REMEDY):
            features = json.loads((place / "meta" / "info.json").read_text(encoding="utf-8"))["features"]
            cameras = [name for name, about in features.items() if about["dtype"] in ("image", "video")]
            if not cameras:
                raise PalpateError(f"{place.name} has no camera.", _REMEDY, code="recording-no-images")
            camera = self.choose(place.name, cameras)
            tables = [parquet.read_table(path) for path in sorted((place / "data").rglob("*.parquet"))]
            if not tables:
                raise PalpateError(
                    f"{place.name} has no table in its folder data.", _REMEDY, code="recording-no-table"
                )
            columns = _columns(tables, features, cameras)
            images = (
                _videos(place, camera, columns, parquet)
                if features[camera]["dtype"] == "video"
                else _Cells([cell for table in tables for cell in table.column(camera).to_pylist()], place)
            )
        return RecordingTable(place.name, columns, {}), images


def _columns(tables: Sequence[Any], features: dict[str, Any], cameras: Sequence[str]) -> dict[str, Column]:
    columns: dict[str, Column] = {}
    for name, about in features.items():
        if name in cameras or not all(name in table.column_names for table in tables):
            continue
        found = [cell for table in tables for cell in table.column(name).to_pylist()]
        try:
            cells = np.array(found, dtype=float)
        except (TypeError, ValueError):
            columns[name] = np.array([str(cell)[:240] for cell in found])  # text; a pose is not made of it
            continue
        cells = cells.reshape(len(cells), -1)
        names = about.get("names")
        names = next(iter(names.values())) if isinstance(names, dict) else names
        if not isinstance(names, list) or len(names) != cells.shape[1]:
            names = [name] if cells.shape[1] == 1 else [f"{name}_{number}" for number in range(cells.shape[1])]
        for number, own in enumerate(names):
            key = (
                own if cells.shape[1] > 1 and own not in columns else name if cells.shape[1] == 1 else f"{name}_{own}"
            )
            columns[str(key)] = cells[:, number]
    return columns


def _videos(folder: Path, camera: str, columns: dict[str, Column], parquet: Any) -> ImageSet:
    """Return the images of the rows: in the video of their episode, or from its start in a joint video."""
    episode = columns["episode_index"].astype(int)
    frame = columns["frame_index"].astype(int)
    paths = sorted(path for path in (folder / "videos").rglob("*.mp4") if camera in path.parts)
    about = sorted((folder / "meta" / "episodes").rglob("*.parquet"))
    if not about:  # version 2: a video an episode
        owner = {int(path.stem.rpartition("_")[2]): number for number, path in enumerate(paths)}
        return VideoImages(paths, [owner[number] for number in episode], frame.tolist())
    fps = float(json.loads((folder / "meta" / "info.json").read_text(encoding="utf-8"))["fps"])
    start: dict[int, tuple[int, int]] = {}
    for table in map(parquet.read_table, about):
        for row in table.to_pylist():
            chunk, number = (int(row[f"videos/{camera}/{key}_index"]) for key in ("chunk", "file"))
            path = folder / "videos" / camera / f"chunk-{chunk:03d}" / f"file-{number:03d}.mp4"
            first = round(float(row[f"videos/{camera}/from_timestamp"]) * fps)
            start[int(row["episode_index"])] = (paths.index(path), first)
    which = [start[number][0] for number in episode]
    return VideoImages(
        paths, which, [start[number][1] + at for number, at in zip(episode, frame.tolist(), strict=True)]
    )


@final
class _Cells(SeparateImages):
    """Images kept as cells: the bytes of a file, or its path."""

    def __init__(self, cells: Sequence[Any], folder: Path) -> None:
        self._cells, self._folder = cells, folder

    def stamp(self, number: int) -> str:
        cell = self._cells[number]
        return f"{cell.get('path')} {len(cell.get('bytes') or b'')}"

    def image(self, number: int) -> NDArray[Any]:
        cell = self._cells[number]
        content = cell.get("bytes")
        return (
            decode_image(content, f"Image {number}") if content else read_image(self._folder / str(cell.get("path")))
        )
