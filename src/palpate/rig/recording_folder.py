"""Folder of a recording in progress: images, their table of poses, and settings.

``poses.csv`` is the table that `palpate.sensor.read_ground_truth` and `palpate.datasets.read_recording` read. An
image is written before its row, so an image with a row is complete, and one without is taken again.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError, atomic_write, load_opencv, provenance, wrap_write_errors
from palpate.core.files import DRAFT
from palpate.core.report import json_text, write_csv
from palpate.datasets import REST
from palpate.design import TILT_SPACE

_COLUMNS = ("image", "press", *TILT_SPACE.names, "taken")


class RecordingFolder:
    """Recording that grows by one image at a time.

    Parameters
    ----------
    folder
        The folder; created by `write_plan`.
    settings
        Plain data that must be equal in all parts of one recording.

    Attributes
    ----------
    plan
        Further plain data of the recording, such as its presses.

    Raises
    ------
    PalpateError
        If the folder has other files or a recording with other settings, or cannot be written.
    """

    def __init__(self, folder: Path, settings: Mapping[str, Any]) -> None:
        self.folder, self._about = folder, folder / "recording.json"
        self._settings = json.loads(json_text(dict(settings)))
        self._rows: list[list[str]] = []
        self.plan: dict[str, Any] = {}
        if self._about.exists():
            self._resume()
        elif folder.exists() and any(not path.name.startswith(DRAFT) for path in folder.iterdir()):
            raise PalpateError(
                f"{folder} has files of something else.", "Choose another folder.", code="folder-exists"
            )

    def _resume(self) -> None:
        try:
            about = json.loads(self._about.read_text(encoding="utf-8"))
            before, self.plan = dict(about["settings"]), dict(about["plan"])
        except (ValueError, LookupError, TypeError):
            before = {}
        if before != self._settings:
            both = before | self._settings
            changed = [name for name in both if before.get(name) != self._settings.get(name)]
            raise PalpateError(
                f"{self.folder} has a recording with another {', '.join(changed)}.",
                "Give the flags of that recording, or choose another folder.",
                code="recording-settings-differ",
            )
        with wrap_write_errors(self.folder, "Choose another folder."):
            for draft in self.folder.glob(f"{DRAFT}*"):
                shutil.rmtree(draft)
        table = self.folder / "poses.csv"
        if table.exists():
            lines = table.read_text(encoding="utf-8").splitlines()[1:]
            self._rows = [line.split(",") for line in lines]

    def __contains__(self, name: object) -> bool:
        return any(row[0] == name for row in self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def write_plan(self, **plan: Any) -> None:
        """Add to the plan, and write it."""
        self.plan |= json.loads(json_text(plan))
        content = {"settings": self._settings, "plan": self.plan, "made_by": provenance()}
        with wrap_write_errors(self.folder, "Choose another folder."):
            self.folder.mkdir(parents=True, exist_ok=True)
        with atomic_write(self._about) as draft:
            draft.write_text(json_text(content) + "\n", encoding="utf-8")

    def add(self, name: str, image: NDArray[Any], press: str = REST, pose: FloatArray | None = None) -> None:
        """Write an image (h, w) or (h, w, 3), then its row; `pose` is rx, ry (degrees) and depth (mm)."""
        encoded: NDArray[np.uint8] = load_opencv().imencode(".png", image)[1]
        with atomic_write(self.folder / name) as draft:
            draft.write_bytes(encoded.tobytes())
        numbers = ["", "", ""] if pose is None else [f"{value:.6f}" for value in pose]
        taken = datetime.now(UTC).isoformat(timespec="milliseconds")
        self._rows.append([name, press, *numbers, taken])
        write_csv(self.folder / "poses.csv", self._rows, _COLUMNS)
