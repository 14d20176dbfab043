"""Numbers of images in videos with a table: by time, by order, or by a column that counts from 1."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from palpate.camera import open_source, recording_suffixes
from palpate.core import FloatArray, PalpateError
from palpate.core.files import natural_key
from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.read_forces import find_times
from palpate.datasets.recording_columns import list_columns
from palpate.datasets.recording_images import list_below
from palpate.datasets.table import REST, RecordingTable, as_numbers

_COUNTER = re.compile(r"(?:video[_ ]?)?frame[_ ]?(?:index|idx|number|num|no|id|nr)?\.?")
"""Names of columns that number the images of a video."""
_REMEDY = "Number the images from 0 in a column called frame, or write their times since the video's first image."


def list_videos(folder: Path) -> list[Path]:
    """Videos of a folder, in natural order; hidden files are passed over."""
    found = (path for path in folder.iterdir() if path.suffix.lower() in recording_suffixes())
    return sorted((path for path in found if path.name[0] != "."), key=lambda path: natural_key(path.name))


def videos_of_rows(table: RecordingTable, videos: list[Path]) -> list[int] | None:
    """Number of each row's video, by the column of their file names; `None` without such a column."""
    numbers = {path.name: number for number, path in enumerate(videos)}
    for name, values in table.columns.items() if videos else ():
        if not table.is_numeric(name):
            files = [Path(str(text).replace("\\", "/")).name for text in values]
            if files and all(file in numbers for file in files):
                return [numbers[file] for file in files]
    return [0] * len(table) if len(videos) == 1 else None


def number_frames(table: RecordingTable, folder: Path, choice: ColumnMapping) -> RecordingTable:
    """Add a column ``frame`` if the images are in videos: by a counter, by time, or by order.

    Rows without an image at their time are left out, and all but the nearest to one image.

    Raises
    ------
    PalpateError
        If the times or the number of rows do not match, or a video cannot be read.
    """
    videos = list_videos(folder)
    which = videos_of_rows(table, videos)
    if which is None or choice.image or any(path.stem.lower() != REST for path in list_below(folder)):
        return table
    counter = next((name for name in table.columns if _COUNTER.fullmatch(name.strip().lower())), "")
    frames, notes = np.full(len(table), np.nan), list[str]()
    for number in sorted(set(which)):
        rows = np.flatnonzero(np.array(which) == number)
        frames[rows], note = _number(table.rows(rows), videos[number], counter, choice)
        notes.append(note)
    kept = np.isfinite(frames)
    if not kept.all():
        notes.append(f"{(~kept).sum()} of {len(kept)} rows have no image of their own and are left out")
    columns = {name: values for name, values in table.columns.items() if name != counter} | {"frame": frames}
    return replace(table, columns=columns, notes=(*table.notes, *filter(None, dict.fromkeys(notes)))).rows(kept)


def _number(table: RecordingTable, video: Path, counter: str, choice: ColumnMapping) -> tuple[FloatArray, str]:
    """Number of the image of each row, NaN without one, and a note."""
    numbers = as_numbers(table.columns[counter]) if counter else np.arange(len(table), dtype=float)
    if counter and numbers.min() != 1:
        return numbers, ""
    with open_source(str(video)) as source:
        damage = [image for image in source.images() if isinstance(image, PalpateError)]
        time = np.array(source.times)
    if damage:
        raise damage[0]
    if counter:
        from_one = numbers.max() == len(time)
        return numbers - from_one, f"{counter} counts the images from 1" if from_one else ""
    try:
        asked = find_times(table, choice)[1]
    except PalpateError as error:
        if error.code != "time-column-missing":
            raise
        if len(time) == len(table):
            return numbers, "no column numbers the images of the video: rows are taken in their order"
        raise PalpateError(
            f"{video.name} has {len(time)} images, {table.name} {len(table)} rows of it and no column that numbers "
            f"them; it has {list_columns(table)}.",
            _REMEDY,
            code="image-column-missing",
        ) from error
    period = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    inside = (asked >= time[0] - period) & (asked <= time[-1] + period)
    if inside.sum() < 0.5 * len(asked):
        raise PalpateError(
            f"The images of {video.name} are at {time[0]:.3f} to {time[-1]:.3f} s, the rows of {table.name} at "
            f"{asked.min():.3f} to {asked.max():.3f} s.",
            _REMEDY,
            code="times-no-overlap",
        )
    nearest = np.searchsorted((time[1:] + time[:-1]) / 2, asked)
    order = np.lexsort((np.abs(asked - time[nearest]), nearest))
    own = np.isin(np.arange(len(asked)), order[np.unique(nearest[order], return_index=True)[1]])
    return np.where(inside & own, nearest, np.nan), "rows are matched to the images of the video by time"
