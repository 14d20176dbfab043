"""The artefact store: what a stage made is kept under a key of everything that could change it.

    key = SHA-256 of (kind, spec, keys of the inputs, version of the code that matters)

    ROOT/<kind>/<key[:2]>/<key><suffix>          the artefact
    ROOT/<kind>/<key[:2]>/<key>.manifest.json   its checksum, spec, inputs and versions

An artefact appears whole or not at all: it is written to a temporary file, flushed to the disk and renamed.
Its checksum is verified when it is looked up; a broken file is set aside as ``*.broken`` and made again.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from palpate.core.errors import PalpateError
from palpate.core.provenance import provenance

KEY_LENGTH = 32
"""Hexadecimal digits of a key: 128 bits."""


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
        """Where the artefact of `recipe` lies, whether or not it exists."""
        return self.root / recipe.kind / recipe.key[:2] / f"{recipe.key}{suffix}"

    def find(self, recipe: Recipe, suffix: str = ".h5") -> Path | None:
        """Path of a whole artefact, or `None` where there is none; a broken one is set aside on the way."""
        path = self.path(recipe, suffix)
        if not path.is_file():
            return None
        if _recorded_checksum(_manifest_path(path)) == _checksum(path):
            return path
        os.replace(path, path.with_name(path.name + ".broken"))
        return None

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
        PalpateError
            If the folder cannot be written.
        """
        path = self.path(recipe, suffix)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix=".writing-", dir=path.parent) as folder:
                draft = Path(folder) / path.name
                writer(draft)
                _flush(draft)
                manifest = Path(folder) / "manifest.json"
                manifest.write_text(_manifest(recipe, _checksum(draft)))
                _flush(manifest)
                os.replace(manifest, _manifest_path(path))
                os.replace(draft, path)
            if os.name == "posix":
                _flush(path.parent)  # the new name itself, not only the content
        except OSError as error:
            raise PalpateError(
                f"The artefact store {self.root} cannot be written: {error.strerror or error}.",
                "Choose another folder with --out, or free some space.",
            ) from error
        return path


def _manifest_path(path: Path) -> Path:
    return path.with_suffix(".manifest.json")


def _manifest(recipe: Recipe, checksum: str) -> str:
    content = {
        "kind": recipe.kind,
        "key": recipe.key,
        "sha256": checksum,
        "spec": recipe.spec,
        "inputs": list(recipe.inputs),
        "version": recipe.version,
        "made_by": provenance(),
    }
    return json.dumps(content, indent=2) + "\n"


def _recorded_checksum(manifest: Path) -> str | None:
    try:
        content = json.loads(manifest.read_text())
    except (OSError, ValueError):
        return None
    checksum = content.get("sha256") if isinstance(content, dict) else None
    return checksum if isinstance(checksum, str) else None


def _checksum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
