"""Recordings read from a folder or file: table, images and their poses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from palpate.camera import read_image
from palpate.core import FloatArray, IntArray, PalpateError, generator
from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.pose_column import PoseColumn
from palpate.datasets.read_forces import add_forces
from palpate.datasets.recording_columns import (
    INDEX,
    TIME,
    find_gaps,
    find_image_column,
    find_pose_columns,
    find_press_column,
)
from palpate.datasets.recording_images import (
    ConcatenatedImages,
    ImageFiles,
    ImageSet,
    SelectedImages,
    VideoImages,
    find_files,
    find_numbered_files,
    list_below,
)
from palpate.datasets.recording_reader import READERS, RecordingReader
from palpate.datasets.surface_poses import to_surface
from palpate.datasets.table import REST, RecordingTable
from palpate.datasets.video_frames import list_videos, number_frames, videos_of_rows

LEAST_IMAGES, LEAST_PRESSES = 8, 8
"""Minimum numbers of images and presses of a recording. By hand."""


@dataclass(frozen=True, eq=False)
class Recording:
    """Images with poses.

    Attributes
    ----------
    name
        Name of the recording.
    images
        The images; first those of presses, in the order of the poses, then those at rest.
    names
        (n,) names of the images.
    poses
        Quantities to estimate, (n,) values each.
    others
        Further quantities of the motion.
    press
        (n,) number of the press.
    rest
        Number of images at rest, after the n of presses.
    notes
        Omissions and assumptions, one sentence each.
    """

    name: str
    images: ImageSet
    names: tuple[str, ...]
    poses: tuple[PoseColumn, ...]
    others: tuple[PoseColumn, ...]
    press: IntArray
    rest: int
    notes: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.names)

    @property
    def targets(self) -> FloatArray:
        """(n, k) quantities to estimate, degrees and mm."""
        return np.stack([one.values for one in self.poses], axis=1)

    @property
    def presses(self) -> int:
        """Number of presses."""
        return len(np.unique(self.press))


def read_recording(
    place: Path, choice: ColumnMapping | None = None, rest: Path | None = None, most: int = 20_000, seed: int = 0
) -> Recording:
    """Read a recording.

    Parameters
    ----------
    place
        A file or folder that a reader accepts (`READERS`), or a folder that holds one such file.
    choice
        Meaning of columns whose names do not state it.
    rest
        An image of the unloaded sensor, if the table names no such image.
    most, seed
        Most images; more are thinned out by whole presses, drawn by the seed.

    Raises
    ------
    PalpateError
        If it cannot be read, or has too few images or presses.
    """
    choice = choice or ColumnMapping()
    reader, place = _find_reader(place)
    if rest is not None:
        read_image(rest)  # refused here, by its own sentence
    if choice.pose and not reader.has_topics:
        raise PalpateError(
            f"{place.name} has no topic {choice.pose}: it is not a ROS bag.",
            "Leave --pose out; --targets chooses columns.",
            code="flag-not-used",
        )
    reads = reader()
    reads.image, reads.pose = choice.image, choice.pose
    table, images = reads.read(place)
    folder = place.parent
    if images is None and choice.image not in table.columns and (folder / choice.image).is_dir():
        folder, choice = folder / choice.image, replace(choice, image="")
    table = table if images is not None else number_frames(table, folder, choice)
    notes = [f"{place.name}: {note}." for note in table.notes]
    by = find_press_column(table, choice)
    column, files = ("", None) if images is not None else _name_images(table, choice, folder, notes)
    if files is not None:
        images, rest = files, rest or _find_rest(folder)
    chosen, at_rest = _split_rest(table, by, column)
    kept = _thin(_press_numbers(table, by)[chosen], most, seed)
    if len(kept) < len(chosen):
        notes.append(
            f"{len(chosen)} images, of which {len(kept)} are used (whole presses, drawn by seed {seed}); "
            "--max-images for more."
        )
    chosen, posed = chosen[kept], table.rows(chosen[kept])
    if choice.forces is not None:
        shown = _find_images(folder, posed, column) if images is None else SelectedImages(images, chosen.tolist())
        posed, within = add_forces(posed, shown, choice)
        chosen, posed = chosen[within], posed.rows(within)
    gaps, said = find_gaps(posed, choice)
    notes += [f"{place.name}: {said}."] if said else []
    chosen, posed = chosen[~gaps], posed.rows(~gaps)
    posed = to_surface(posed, choice, (by, column))
    notes += [f"{note}." if not note.endswith(".") else note for note in posed.notes[len(table.notes) :]]
    poses, others, left_out = find_pose_columns(posed, choice, (by, column))
    rows = np.concatenate([chosen, at_rest])
    if images is None:
        names = tuple(str(text) for text in table.columns[column][rows].tolist())
        images = _find_images(folder, table.rows(rows), column)
        rest = rest or (None if len(at_rest) else _find_rest(place.parent))
    else:
        names = tuple(f"image {row}" for row in rows)
        images = SelectedImages(images, rows.tolist())
    if rest is not None:
        images, at_rest = ConcatenatedImages(images, len(chosen), ImageFiles([rest])), np.zeros(1, int)
    press = np.unique(_press_numbers(table, by)[chosen], return_inverse=True)[1].reshape(-1)
    notes += [one.note for one in (*poses, *others) if one.note] + list(left_out)
    if not by:
        notes.append("No column names the press: each image counts as a press of its own.")
    found = Recording(place.name, images, names[: len(chosen)], poses, others, press, len(at_rest), tuple(notes))
    _refuse_small(found)
    return found


def _name_images(
    table: RecordingTable, choice: ColumnMapping, folder: Path, notes: list[str]
) -> tuple[str, ImageSet | None]:
    """Column that names the images; without one, the images if the folder has one for each row.

    Then rows are taken in the natural order of the file names, unless a column of numbers contradicts it.
    """
    try:
        return find_image_column(table, choice), None
    except PalpateError as error:
        files = [path for path in list_below(folder) if path.stem.lower() != REST]
        stems = {path.stem.casefold() for path in files}
        texts = [name for name in table.columns if not table.is_numeric(name)]
        called = [name for name in texts if {str(text).casefold() for text in table.columns[name]} - {REST} <= stems]
        if called and error.code == "image-column-missing":
            return called[0], None
        low = {name: name.strip().lower() for name in table.columns}
        counts = (table.columns[name] for name, key in low.items() if key in INDEX or TIME.fullmatch(key))
        ordered = all(values.dtype.kind == "U" or bool((np.diff(values) > 0).all()) for values in counts)
        together = len({path.parent for path in files}) == 1
        if error.code != "image-column-missing" or len(files) != len(table) or not (ordered and together):
            raise
        notes.append(f"No column names images: rows are taken as {files[0].name} to {files[-1].name}, in order.")
        return "", ImageFiles(files)


def _find_rest(folder: Path) -> Path | None:
    """An image of the untouched sensor that the table does not name."""
    return next((path for path in list_below(folder) if path.stem.lower() == REST), None)


_ABOUT = ("readme", "license", "licence", "notes")
"""Names of texts about a recording, which are no tables of it."""


def _find_reader(place: Path) -> tuple[type[RecordingReader], Path]:
    """The reader of a file or folder, or of the one file in a folder that a reader accepts."""
    if not place.exists():
        raise PalpateError(
            f"{place} does not exist.", "Give a folder with a table of poses, or the table.", code="file-missing"
        )
    readers = [reader for _, reader in READERS.available()]
    for reader in readers:
        if reader.accepts(place):
            return reader, place
    if place.is_file():
        raise PalpateError(
            f"{place.name} is no table that is known.",
            f"Known are {', '.join(reader.formats for reader in readers)}.",
            code="file-ending-unknown",
        )
    files = sorted(place.iterdir())
    about = {path for path in files if path.stem.lower() in _ABOUT and path.suffix.lower() in ("", ".txt", ".md")}
    files = [path for path in files if path not in about]
    others = [path for path in files if path.suffix.lower() != ".json"]
    for reader, held in ((reader, held) for held in (others, files) for reader in readers):
        tables = [path for path in held if reader.accepts(path)]
        if len(tables) == 1 or (tables and len({path.read_bytes() for path in tables}) == 1):
            return reader, tables[0]
        if tables:
            raise PalpateError(
                f"{place} holds {len(tables)} tables: {', '.join(path.name for path in tables[:5])}.",
                "Name one of them.",
                code="recording-several-tables",
            )
    raise PalpateError(
        f"{place} holds no table of poses.",
        "Write a CSV with a row an image: its name, and its pose.",
        code="recording-no-table",
    )


def _split_rest(table: RecordingTable, by: str, column: str) -> tuple[IntArray, IntArray]:
    at_rest = np.zeros(len(table), bool)
    if by and not table.is_numeric(by):
        at_rest |= np.char.lower(table.columns[by].astype(str)) == REST
    if column and not table.is_numeric(column):
        stems = (Path(str(text)).stem.lower() for text in table.columns[column])
        at_rest |= np.fromiter((stem == REST for stem in stems), bool, len(table))
    return np.flatnonzero(~at_rest), np.flatnonzero(at_rest)


def _press_numbers(table: RecordingTable, by: str) -> IntArray:
    """(n,) numbers of presses in the order in which they come."""
    if not by:
        return np.arange(len(table))
    _, first, number = np.unique(table.columns[by], return_index=True, return_inverse=True)
    order = np.empty(len(first), int)
    order[np.argsort(first, kind="stable")] = np.arange(len(first))
    return np.asarray(order[number.reshape(-1)])


def _thin(press: IntArray, most: int, seed: int) -> IntArray:
    """Rows of whole presses, at most so many."""
    if len(press) <= most:
        return np.arange(len(press))
    numbers, member, counts = np.unique(press, return_inverse=True, return_counts=True)
    order = generator(seed, "thin").permutation(len(numbers))
    kept = order[: max(int(np.searchsorted(np.cumsum(counts[order]), most, side="right")), 1)]
    return np.flatnonzero(np.isin(member.reshape(-1), kept))[:most]


def _find_images(folder: Path, table: RecordingTable, column: str) -> ImageSet:
    if not table.is_numeric(column):
        try:
            return ImageFiles(find_files(folder, [str(text) for text in table.columns[column].tolist()]))
        except OSError as error:  # a name that no file system takes
            raise PalpateError(
                f"An image of column {column} has a name that cannot be opened: {error.strerror}.",
                "Check the column of image names.",
                code="images-missing",
            ) from error
    numbers = table.columns[column]
    if not np.array_equal(numbers, np.round(numbers)):
        raise PalpateError(
            f"Column {column} holds {numbers[numbers != np.round(numbers)][0]:g}, which numbers no image.",
            "Name the column of image files or numbers by --image.",
            code="image-number-wrong",
        )
    videos = list_videos(folder)
    which = videos_of_rows(table, videos)
    if which is None and (images := find_numbered_files(folder, table.columns[column].astype(int).tolist())):
        return ImageFiles(images)
    if which is None:
        raise PalpateError(
            f"Column {column} numbers images {numbers.min():g} to {numbers.max():g}, and {folder} holds "
            f"{len(videos)} videos and no image of each number.",
            "Put the one video or the images at the table, or name the video or image of each row in a column.",
            code="recording-several-videos",
        )
    return VideoImages(videos, which, table.columns[column].astype(int).tolist())


def _refuse_small(found: Recording) -> None:
    if len(found) < LEAST_IMAGES:
        raise PalpateError(
            f"The recording has {len(found)} images.", f"Give {LEAST_IMAGES} or more.", code="recording-few-images"
        )
    if found.presses < LEAST_PRESSES:
        raise PalpateError(
            f"The recording has {found.presses} {'press' if found.presses == 1 else 'presses'}: too few "
            "for a test set.",
            f"Record {LEAST_PRESSES} presses or more; if its press column means something else, give --press.",
            code="recording-few-presses",
        )
