"""Selection of a sensor on the live page: a unit of a design, or a model trained on a recording."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from pathlib import Path
from typing import final

from nicegui import ui

from palpate.camera import Source, open_source
from palpate.core import PalpateError
from palpate.sensor import Unit, open_model
from palpate.simulation import SimulatedSource, sample_presses
from palpate.study import design_label, ranking_column
from palpate.surrogate import twin_path
from palpate.viewer.library import DesignLibrary
from palpate.viewer.live import Live, open_live, open_recorded_live
from palpate.viewer.recordings import find_recordings, inside
from palpate.viewer.results import GridDesign, model_path
from palpate.viewer.trained import TrainedSensor

_VIRTUAL = "virtual touches"
_FIELD = "dense outlined options-dense"
_CAMERAS = {"camera 0": "0", "camera 1": "1"}
"""Cameras of the machine that the viewer runs on."""


class LiveOpening(ABC):
    """Selection of a sensor by one visitor; `build` places the fields, `open` opens the sensor.

    Attributes
    ----------
    folder
        Folder of the results; recordings below it are offered.
    reach_deg
        Tilt at the edge of the dial.
    """

    reach_deg: float = 12.0

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @abstractmethod
    def build(self) -> None:
        """Place the fields."""

    @abstractmethod
    def open(self) -> Live:
        """Open the selected sensor.

        Raises
        ------
        PalpateError
            If it cannot be opened.
        """

    def _build_sources(self, more: tuple[str, ...]) -> ui.select:
        """Return the field of the image source: those given, recordings below the folder, cameras."""
        names = [*more, *find_recordings(self.folder), *_CAMERAS]
        field = ui.select(names, value=names[0], label="Images").classes("wide")
        return field.props(_FIELD + ' data-testid="source"')

    def _open_source(self, chosen: str) -> Source:
        return open_source(_CAMERAS.get(chosen) or str(inside(self.folder, chosen)))


@final
class DesignOpening(LiveOpening):
    """A unit of a design of a grid, read by its twin or its network.

    Parameters
    ----------
    library
        Designs with their models, and recordings in their folders.
    """

    def __init__(self, library: DesignLibrary) -> None:
        super().__init__(library.results.folder)
        self._library = library
        self._rows = library.results.grid.designs

    def build(self) -> None:
        names = {i: design_label(row) for i, row in enumerate(self._rows) if row.get("estimator_key")}
        rank = ranking_column(self._rows[0]) if self._rows else ""
        best = min(names, key=lambda i: float(self._rows[i].get(rank) or math.inf), default=None)
        self._design = ui.select(names, value=best, label="Unit of the design", with_input=True)
        self._design.props(_FIELD + ' data-testid="unit"').classes("wide")
        self._source = self._build_sources((_VIRTUAL,))
        self._marked = ui.checkbox("The orientation mark is printed", value=True).props("dense")
        ui.label("Folders of images and videos inside the result folder are listed.").classes("faint")
        ui.label("The first image shows the dome at rest.").classes("faint")

    def open(self) -> Live:
        if self._design.value is None:
            raise PalpateError(
                "No design of this grid has a trained model.",
                "Run the study with its learning.",
                code="model-missing",
            )
        design = self._library.design(int(self._design.value))
        twin, chosen = twin_path(self.folder, design.design.skin), str(self._source.value)
        model = open_model(twin if twin.is_file() else model_path(self._library.results, design))
        source = self._touches(design) if chosen == _VIRTUAL else self._open_source(chosen)
        try:
            return open_live(design, model, source, marked=chosen == _VIRTUAL or bool(self._marked.value))
        except PalpateError:
            source.close()
            raise

    def _touches(self, design: GridDesign) -> Source:
        unit = Unit(design.design)
        return SimulatedSource(unit, sample_presses(self._library.specimen(design).pressed.solved))


@final
class TrainedOpening(LiveOpening):
    """A sensor trained on a recording.

    Parameters
    ----------
    sensor
        The folder of `palpate recording train`.
    """

    def __init__(self, sensor: TrainedSensor) -> None:
        super().__init__(sensor.folder)
        self._model = sensor.model
        low, high = sensor.model.about["range"]
        if sensor.model.space.is_tilt:
            self.reach_deg = math.ceil(max(math.hypot(*low[:2]), math.hypot(*high[:2])))

    def build(self) -> None:
        self._source = self._build_sources(())
        ui.label("Folders of images and videos below the folder of the model are listed.").classes("faint")
        ui.label("Every image is read by itself; none needs to show the sensor at rest.").classes("faint")

    def open(self) -> Live:
        source = self._open_source(str(self._source.value))
        try:
            return open_recorded_live(self._model, source)
        except PalpateError:
            source.close()
            raise
