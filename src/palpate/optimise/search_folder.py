"""Read-only view of the folder of a search: trials, front, and parts of each design.

A running search has a journal and no front yet: its trials are read from the journal line by line, without Optuna.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from palpate.camera import CameraSpec
from palpate.core import PalpateError, rename_columns
from palpate.design import Design, MarkerSpec, SkinSpec, skin_from_data
from palpate.material import get_material
from palpate.optimise.front import DesignCandidate, Front, SkinTrial
from palpate.optimise.optimise_design import ASKED, JOURNAL
from palpate.optimise.skin_evaluation import SkinEvaluation
from palpate.optimise.spec import RequirementsSpec
from palpate.optimise.write_front import FRONT, describe_entry

Row = Mapping[str, Any]
_COMPLETE = 1
"""State of a completed trial in the journal."""
_AGAIN = "Run `palpate search` again with this folder: it resumes the search."


@dataclass(frozen=True, eq=False)
class SearchFolder:
    """Contents of the folder of a search.

    Attributes
    ----------
    folder, spec
        The folder and the requirements.
    rows
        Figures of designs: the front, non-dominated designs by coarse presses only, the best of every trial.
    front
        Number of designs on the front.
    coarse
        Number of non-dominated designs without fine presses; 0 unless the search has finished.
    winner
        Index of the winner; -1 without one.
    skins
        Number of trials.
    finished
        Whether the search has finished; else the front is the best so far, by coarse presses.
    """

    folder: Path
    spec: RequirementsSpec
    rows: tuple[Row, ...]
    front: int
    coarse: int
    winner: int
    skins: int
    finished: bool

    def design(self, number: int) -> Design:
        """One design of the search.

        Raises
        ------
        PalpateError
            If the row does not exist, or has no complete design.
        """
        if not 0 <= number < len(self.rows):
            raise PalpateError(
                f"There is no design {number}.",
                f"There are designs 0 to {len(self.rows) - 1}.",
                code="design-unknown",
            )
        row = self.rows[number]
        try:
            material = get_material(str(row["material"]))
            return Design(_skin(row), _markers(row, self.spec), self._camera(row), material)
        except (KeyError, TypeError, ValueError, ValidationError) as error:
            raise PalpateError(
                f"Row {number} of the search is no design: {error}.", _AGAIN, code="design-row-unreadable"
            ) from None

    def _camera(self, row: Row) -> CameraSpec:
        choice = next((one for one in self.spec.cameras if one.name == row["camera"]), None)
        if choice is None:
            raise ValueError(f"the requirements have no camera {row['camera']}")
        return choice.camera.model_copy(update={"distance": float(row["distance_mm"])})


def is_search(folder: Path) -> bool:
    """Whether a folder is that of a search, finished or not."""
    return (folder / ASKED).is_file() and (folder / JOURNAL).is_file()


def read_search(folder: Path) -> SearchFolder:
    """Read the present state of a search.

    Raises
    ------
    PalpateError
        If the folder contains no search, or an unreadable one.
    """
    if not is_search(folder):
        raise PalpateError(
            f"{folder} holds no search.", "Give the folder of `palpate search`.", code="search-missing"
        )
    try:
        asked = json.loads((folder / ASKED).read_text("utf-8"))
        spec = RequirementsSpec.model_validate({name: asked[name] for name in asked if name != "sampler"})
        tried = tuple(_read_journal(folder / JOURNAL))
        ended = json.loads((folder / FRONT).read_text("utf-8")) if (folder / FRONT).is_file() else {}
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise PalpateError(
            f"The search in {folder} cannot be read: {error}.", _AGAIN, code="search-unreadable"
        ) from error
    known = Front(spec, tried)
    others = [
        describe_entry(DesignCandidate(one, best))
        for one in tried
        if (best := one.finest.best(spec.markers)) is not None
    ]
    finished = ended.get("skins") == len(tried)  # a search that goes on has tried more
    front: Sequence[Row] = (
        [rename_columns(row) for row in ended["front"]]
        if finished
        else [describe_entry(entry) for entry in known.pareto]
    )
    coarse = [rename_columns(row) for row in ended.get("coarse_front", ())] if finished else []
    first: Row | None = (
        ended["winner"] and rename_columns(ended["winner"])
        if finished
        else describe_entry(known.winner)
        if known.winner
        else None
    )
    winner = next((number for number, row in enumerate(front) if row == first), -1)
    return SearchFolder(
        folder, spec, (*front, *coarse, *others), len(front), len(coarse), winner, len(tried), finished
    )


def _read_journal(path: Path) -> Iterator[SkinTrial]:
    """Yield the evaluated skins by number; an incomplete last line is skipped."""
    notes: dict[int, dict[str, Any]] = {}
    done = []
    for line in path.read_text("utf-8").splitlines():
        try:
            record = json.loads(line)
        except ValueError:
            continue
        if "user_attr" in record:
            notes.setdefault(record["trial_id"], {}).update(record["user_attr"])
        elif record.get("state") == _COMPLETE and record.get("values") and "trial_id" in record:
            done.append(record["trial_id"])
    for number in sorted(set(done) & set(notes)):
        note = notes[number]
        yield SkinTrial(number, SkinEvaluation.from_data(note["note"]["proposal"]), note["violations"])


def _skin(row: Row) -> SkinSpec:
    sizes = {name: float(row[f"{name}_mm"]) for name in ("height", "base_radius", "thickness")}
    ratios = {name: float(row.get(name, 1.0)) for name in ("aspect", "taper")}
    shape = {} if set(ratios.values()) == {1.0} else {"kind": "ellipsoid", **ratios}
    return skin_from_data({**shape, **sizes})


def _markers(row: Row, spec: RequirementsSpec) -> MarkerSpec:
    rings = [float(word) for word in str(row["ring_diameters_mm"]).split()]
    return MarkerSpec.model_validate(
        {"ring_diameters": rings, "diameter": float(row.get("marker_diameter_mm", spec.min_marker_diameter))}
    )
