"""The artefact store: what a stage made is kept under a key of everything that could change it.

    key = SHA-256 of (kind, spec, keys of the inputs, version of the code that matters)

    ROOT/<kind>/<key[:2]>/<key><suffix>          the artefact
    ROOT/<kind>/<key[:2]>/<key>.manifest.json   its checksum, spec, inputs and versions

An artefact appears whole or not at all: it is written to a temporary file, flushed to the disk and renamed.
Its checksum is verified when it is looked up to be read; a broken file is set aside as ``*.broken``, with the
reason beside it as ``*.broken.reason``, and made again. While a run is planned, the size is enough: `holds`.
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
"""Endings of what lies beside an artefact."""

_HEAD_BYTES = 512
"""The first bytes of a manifest hold the artefact's size, so that planning need not read its whole spec."""
_KIND = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")
_KEY = re.compile(rf"[0-9a-f]{{2,{KEY_LENGTH}}}")
_SIZE = re.compile(rb'"sha256": "[0-9a-f]{64}",\s*"bytes": (\d+)')


class StoreError(PalpateError):
    """The store cannot be written: nothing more can be kept until somebody has made room."""


@dataclass(frozen=True)
class Recipe:
    """Everything that decides what an artefact contains.

    Attributes
    ----------
    kind
        Name of the stage's noun, e.g. ``"press"``; also the folder in the store.
    spec
        What was chosen, as JSON data.
    inputs
        Keys of the artefacts that the stage reads.
    version
        Version of the code that matters.
    key
        Checksum of these, under which the artefact lies.
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
    """A folder of artefacts, each under the key of its recipe.

    Attributes
    ----------
    root
        Folder of the store; made when the first artefact is written.
    """

    root: Path

    def path(self, recipe: Recipe, suffix: str = ".h5") -> Path:
        """Where the artefact of `recipe` lies, whether or not it exists.

        Raises
        ------
        PalpateError
            If the kind is no plain name: it is a folder in the store.
        """
        return self.locate(recipe.kind, recipe.key, suffix)

    def locate(self, kind: str, key: str, suffix: str = ".h5") -> Path:
        """Where the artefact of a kind and key lies, whether or not it exists; never outside the store.

        Raises
        ------
        PalpateError
            If the kind is no plain name, or the key none of hexadecimal digits.
        """
        if _KIND.fullmatch(kind) is None:
            raise PalpateError(
                f"The kind of artefact {kind!r} is no plain name.",
                "Take letters and digits.",
                code="artefact-kind-malformed",
            )
        if _KEY.fullmatch(key) is None:
            raise PalpateError(
                f"'{key[:40]}' is no key of an artefact.", "Run the study again.", code="artefact-key-malformed"
            )
        return self.root / kind / key[:2] / f"{key}{suffix}"

    def find(self, recipe: Recipe, suffix: str = ".h5") -> Path | None:
        """Path of a whole artefact, or `None` where there is none; a broken one is set aside on the way.

        The whole file is read for its checksum; who reads it afterwards reads what was verified.
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
        """Whether there is an artefact that is whole as far as its size can tell; nothing of it is read.

        One whose size is wrong is set aside. A changed bit is noticed when the artefact is read, see `find`.
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
        """Hold the right to make an artefact, so that two runs of one study do not make it twice.

        The lock is the system's: it ends with its process, however that ends, and knows no clock. Where the file
        system has no locks, everyone gets the right; then an artefact may be made twice, but never half.

        Yields
        ------
        bool
            Whether the right was free; without it, somebody else makes the artefact now.

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
        """Let `writer` write the artefact to a temporary path, then put it under its key.

        Parameters
        ----------
        recipe
            What decides the content.
        writer
            Called with the path to write to; the path has the right suffix and does not exist.
        suffix
            Ending of the file's name.

        Returns
        -------
        Path
            Where the artefact now lies.

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
    """Where the manifest of the artefact at `path` lies."""
    return path.with_suffix(MANIFEST)


def find_corruption(path: Path) -> str:
    """Say in one sentence why the artefact at `path` cannot be trusted; empty where it can."""
    try:
        manifest = json.loads(manifest_path(path).read_bytes())
    except FileNotFoundError:
        return "Its manifest is missing."
    except (OSError, ValueError, RecursionError):
        return "Its manifest cannot be read."
    if not isinstance(manifest, dict) or not isinstance(manifest.get("sha256"), str):
        return "Its manifest names no checksum."
    if (manifest.get("kind"), manifest.get("key")) != (path.parents[1].name, path.stem):
        return "Its manifest is that of another artefact."
    size, recorded = path.stat().st_size, manifest.get("bytes")
    if size == 0:
        return "It is empty."
    if isinstance(recorded, int) and recorded != size:
        return f"It has {size} bytes instead of {recorded}."
    if _checksum(path) != manifest["sha256"]:
        return "Its content has changed: the checksum is another one."
    return ""


def quarantine(path: Path, reason: str) -> None:
    """Take a broken artefact out of the way, with the reason beside it; one in a read-only folder stays."""
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
