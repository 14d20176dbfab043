"""Artefact store: results of stages under a key of everything that affects them.

    key = SHA-256 of (kind, spec, keys of the inputs, version of the code that matters)

    ROOT/<kind>/<key[:2]>/<key><suffix>          the artefact
    ROOT/<kind>/<key[:2]>/<key>.manifest.json   its checksum, spec, inputs and versions

An artefact is written atomically: to a temporary file, which is flushed to the disk and renamed. Its checksum is
verified by `find`, before it is read. A corrupt file is renamed to ``*.broken``, with the reason in
``*.broken.reason``, and made again. While a run is planned, only the size is checked (`has`).
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from palpate.core.errors import PalpateError
from palpate.core.files import DRAFT
from palpate.core.provenance import provenance
from palpate.core.store_lock import lock_folder, take_lock

KEY_LENGTH = 32
"""Hexadecimal digits of a key: 128 bits."""

MANIFEST, BROKEN, REASON, LOCK = ".manifest.json", ".broken", ".broken.reason", ".lock"
"""Suffixes of the files that accompany an artefact."""

_HEAD_BYTES = 512
"""Length of a manifest's beginning that contains the artefact's size; planning reads no more."""
_KIND = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")
_KEY = re.compile(rf"[0-9a-f]{{2,{KEY_LENGTH}}}")
_SIZE = re.compile(rb'"sha256": "[0-9a-f]{64}",\s*"bytes": (\d+)')


class StoreError(PalpateError):
    """Error of a store that cannot be written."""


@dataclass(frozen=True)
class Recipe:
    """Everything that affects the content of an artefact.

    Attributes
    ----------
    kind
        Name of the artefact, e.g. ``"press"``; also the folder in the store.
    spec
        Parameters, as JSON data.
    inputs
        Keys of the artefacts that the stage reads.
    version
        Version of the relevant code.
    key
        Checksum of these, under which the artefact is stored.
    """

    kind: str
    spec: Any
    inputs: tuple[str, ...] = ()
    version: str = ""
    key: str = field(init=False, compare=False)

    def __post_init__(self) -> None:
        text = json.dumps(
            [self.kind, self.spec, list(self.inputs), self.version],
            sort_keys=True,
            separators=(",", ":"),
            allow_nan=False,
        )
        object.__setattr__(self, "key", hashlib.sha256(text.encode()).hexdigest()[:KEY_LENGTH])


@dataclass(frozen=True)
class ArtefactStore:
    """Folder of artefacts, each under the key of its recipe.

    Attributes
    ----------
    root
        Folder of the store; created when the first artefact is written.
    """

    root: Path

    def path(self, recipe: Recipe, suffix: str = ".h5") -> Path:
        """Return the path of the artefact of `recipe`, whether or not it exists.

        Raises
        ------
        PalpateError
            If the kind, a folder in the store, is not a plain name.
        """
        return self.locate(recipe.kind, recipe.key, suffix)

    def locate(self, kind: str, key: str, suffix: str = ".h5") -> Path:
        """Return the path of an artefact by kind and key, whether or not it exists; never outside the store.

        Raises
        ------
        PalpateError
            If the kind is not a plain name, or the key not hexadecimal.
        """
        if _KIND.fullmatch(kind) is None:
            raise PalpateError(
                f"The artefact kind {kind!r} is not a plain name.",
                "Use letters and digits.",
                code="artefact-kind-malformed",
            )
        if _KEY.fullmatch(key) is None:
            raise PalpateError(
                f"'{key[:40]}' is not an artefact key.", "Run the study again.", code="artefact-key-malformed"
            )
        return self.root / kind / key[:2] / f"{key}{suffix}"

    def find(self, recipe: Recipe, suffix: str = ".h5") -> Path | None:
        """Return the path of a valid artefact, or `None`; a corrupt one is quarantined.

        The checksum of the whole file is verified.
        """
        path = self.path(recipe, suffix)
        if not path.is_file():
            return None
        fault = find_corruption(path)
        if not fault:
            return path
        quarantine(path, fault)
        return None

    def has(self, recipe: Recipe, suffix: str = ".h5") -> bool:
        """Return whether an artefact exists with the size in its manifest; its content is not read.

        One of another size is quarantined. A changed bit is detected when the artefact is read, see `find`.
        """
        path = self.path(recipe, suffix)
        try:
            size = os.stat(path).st_size
        except OSError:
            return False
        try:
            with open(manifest_path(path), "rb") as file:
                head = _SIZE.search(file.read(_HEAD_BYTES))
        except OSError:
            head = None
        if head is not None and int(head[1]) == size:
            return True
        return self.find(recipe, suffix) is not None

    @contextmanager
    def lease(self, recipe: Recipe) -> Iterator[bool]:
        """Take the right to make an artefact, so that two runs of one study do not make it twice.

        The lock is the operating system's, and ends with its process. If the file system has no locks, every process
        gets the right; then an artefact may be made twice, but never in part.

        Yields
        ------
        bool
            Whether the right was free; otherwise another process is making the artefact.

        Raises
        ------
        StoreError
            If the folder cannot be written.
        """
        path = self.path(recipe, LOCK)
        with self._writing():
            path.parent.mkdir(parents=True, exist_ok=True)
            lock = take_lock(path)
        try:
            yield lock is not None
        finally:
            if lock is not None:
                lock.release()

    def write(self, recipe: Recipe, writer: Callable[[Path], None], suffix: str = ".h5") -> Path:
        """Write an artefact by `writer` to a temporary path, move it to the path of its key, and return that.

        The path that `writer` gets has the suffix and does not exist.

        Raises
        ------
        StoreError
            If the folder cannot be written.
        """
        path = self.path(recipe, suffix)
        with self._writing():
            path.parent.mkdir(parents=True, exist_ok=True)
            with (
                tempfile.TemporaryDirectory(prefix=DRAFT, dir=path.parent, ignore_cleanup_errors=True) as folder,
                lock_folder(Path(folder)),
            ):
                draft = Path(folder) / path.name
                writer(draft)
                _flush(draft)
                manifest = Path(folder) / "manifest.json"
                manifest.write_text(_manifest(recipe, draft))
                _flush(manifest)
                os.replace(manifest, manifest_path(path))
                os.replace(draft, path)
            if os.name == "posix":
                _flush(path.parent)  # the new name itself, not only the content
        return path

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise StoreError(
                f"The artefact store {self.root} cannot be written: {error.strerror or error}.",
                "Choose another folder with --out, or free some space.",
                code="store-unwritable",
            ) from error


def manifest_path(path: Path) -> Path:
    """Return the path of the manifest of the artefact at `path`."""
    return path.with_suffix(MANIFEST)


def find_corruption(path: Path) -> str:
    """Return the reason why the artefact at `path` is corrupt, in one sentence; empty if it is valid."""
    try:
        manifest = json.loads(manifest_path(path).read_bytes())
    except FileNotFoundError:
        return "Its manifest is missing."
    except (OSError, ValueError, RecursionError):
        return "Its manifest cannot be read."
    if not isinstance(manifest, dict) or not isinstance(manifest.get("sha256"), str):
        return "Its manifest has no checksum."
    if (manifest.get("kind"), manifest.get("key")) != (path.parents[1].name, path.stem):
        return "Its manifest is that of another artefact."
    try:
        size, recorded = path.stat().st_size, manifest.get("bytes")
        if size == 0:
            return "It is empty."
        if isinstance(recorded, int) and recorded != size:
            return f"It has {size} bytes instead of {recorded}."
        if _checksum(path) != manifest["sha256"]:
            return "Its content has changed: the checksum differs."
    except FileNotFoundError:  # another process quarantined it in the meantime
        return "It is missing."
    return ""


def quarantine(path: Path, reason: str) -> None:
    """Rename a corrupt artefact, and write the reason next to it; in a read-only folder it stays."""
    try:
        os.replace(path, path.with_name(path.name + BROKEN))
        path.with_name(path.name + REASON).write_text(reason + "\n")
    except OSError:  # read-only, full, or another process was first: nobody reads it either way
        return


def _manifest(recipe: Recipe, draft: Path) -> str:
    content = {
        "kind": recipe.kind,
        "key": recipe.key,
        "sha256": _checksum(draft),
        "bytes": draft.stat().st_size,
        "spec": recipe.spec,
        "inputs": list(recipe.inputs),
        "version": recipe.version,
        "made_by": provenance(),
    }
    return json.dumps(content, indent=2) + "\n"


def _checksum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
