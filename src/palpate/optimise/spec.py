"""Requirements: what a sensor must do, and what the workshop can make."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Literal

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from palpate.calibration import ToleranceSpec
from palpate.camera import CameraSpec
from palpate.core import PAPER, PalpateError, Spec, parameter
from palpate.design import MarkerSpec, SkinSpec, skin_from_data
from palpate.fabrication import ProcessSpec
from palpate.material import get_material
from palpate.study import DesignsSpec, read_spec

Range = tuple[float, float]
_CAMERA = "davis346"
"""The camera whose numbers are the defaults."""
PRESET = "paper_task"
"""Requirements that come with the package."""
_HINT = f"Give a YAML file, or {PRESET}: the page on requirements in the documentation shows it."
Objective = Literal["error", "force", "markers", "price", "size"]
Proof = Literal["none", "simulated", "trained"]
FIELDS = {
    "heights": "height",
    "base_radii": "base_radius",
    "thicknesses": "thickness",
    "aspects": "aspect",
    "tapers": "taper",
}
"""Ranges of the search, and what each is of a skin."""


class CameraChoice(Spec):
    """A camera that may be built in."""

    name: str = parameter(_CAMERA, unit="", meaning="name of the camera; any but this needs `camera`")
    price: float = parameter(0.0, unit="1", meaning="price in any currency, the same for all cameras", ge=0)
    camera: CameraSpec = CameraSpec()
    distances: Range = parameter((40.0, 54.0), unit="mm", meaning="least and greatest distance below the base plane")

    @field_validator("distances")
    @classmethod
    def _grows(cls, given: Range) -> Range:
        return _growing(given, 1.0, 1000.0, "mm")

    @model_validator(mode="after")
    def _is_known(self) -> CameraChoice:
        if self.name != _CAMERA and "camera" not in self.model_fields_set:
            raise PydanticCustomError(
                "camera-unknown",
                "of the camera {name} nothing is known but its name; give its numbers as camera, or name {known}",
                {"name": self.name, "known": _CAMERA},
            )
        return self


class BaselineDesignSpec(Spec):
    """A design that the winner is held against, in the first of the cameras and elastomers."""

    height: float = parameter(
        20.0, unit="mm", meaning="height of the inner surface's apex", source=PAPER, ge=2, le=60
    )
    base_radius: float = parameter(20.0, unit="mm", meaning="radius of its rim", source=PAPER, ge=5, le=60)
    thickness: float = parameter(2.0, unit="mm", meaning="thickness of the wall", source=PAPER, ge=0.2, le=15)
    aspect: float = parameter(1.0, unit="1", meaning="ratio of the meridian's semi-axes; 1: part of a sphere", gt=0)
    markers: MarkerSpec = MarkerSpec()
    distance: float = parameter(
        48.0, unit="mm", meaning="distance of the camera below the base plane", source=PAPER, gt=0, le=1000
    )

    def skin(self) -> SkinSpec:
        """Its skin."""
        numbers = self.model_dump(include={"height", "base_radius", "thickness"})
        shape = {} if self.aspect == 1.0 else {"kind": "ellipsoid", "aspect": self.aspect}
        return skin_from_data({**shape, **numbers})


class BaselineGridSpec(Spec):
    """A grid of designs that the search is held against, in the first of the cameras and elastomers."""

    designs: DesignsSpec = DesignsSpec()
    distance: float = parameter(
        48.0, unit="mm", meaning="distance of the camera below the base plane", source=PAPER, gt=0, le=1000
    )

    @field_validator("designs")
    @classmethod
    def _has_rings(cls, given: DesignsSpec) -> DesignsSpec:
        if any(markers.file is not None or markers.rows is not None for markers in given.markers):
            raise PydanticCustomError("layout-not-rings", "a grid's layouts are rings; give numbers of markers.", {})
        return given


class RequirementsSpec(Spec):
    """What the sensor must do, within which limits, and what is made least."""

    name: str = Field(
        "search", pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", description="name of the search and its folder"
    )
    seed: int = parameter(0, unit="1", meaning="seed of everything drawn at random", ge=0)
    error_deg: float = parameter(
        0.5, unit="deg", meaning="greatest error of rx or ry that 19 of 20 built units are to stay below", gt=0, le=45
    )
    calibration_presses: int = parameter(
        5, unit="1", meaning="known presses by which each unit is identified before it is used", ge=0, le=100
    )
    min_depth: float = parameter(2.4, unit="mm", meaning="least depth at which it is read", source=PAPER, ge=0.2)
    depth: float = parameter(8.0, unit="mm", meaning="depth to which it is pressed", source=PAPER, gt=0, le=40)
    max_tilt_deg: float = parameter(12.0, unit="deg", meaning="greatest tilt of the wall", source=PAPER, ge=2, le=30)
    force_n: float | None = parameter(
        None, unit="N", meaning="greatest force on the workpiece at full depth; empty: any", gt=0
    )
    single_state: bool = parameter(
        False, unit="", meaning="whether the skin must have no second, inverted state up to full depth"
    )
    heights: Range = parameter((10.0, 30.0), unit="mm", meaning="least and greatest height of the inner surface")
    base_radii: Range = parameter((15.0, 20.0), unit="mm", meaning="least and greatest radius of its rim")
    thicknesses: Range = parameter((1.0, 4.0), unit="mm", meaning="least and greatest thickness of the wall")
    aspects: Range = parameter(
        (0.6, 1.6), unit="1", meaning="least and greatest ratio of a meridian's semi-axes; 1: part of a sphere"
    )
    tapers: Range = parameter(
        (1.0, 1.0), unit="1", meaning="least and greatest thickness at the rim over that at the apex; 1: an even wall"
    )
    markers: int = parameter(169, unit="1", meaning="markers at most", ge=7, le=397)
    min_marker_diameter: float = parameter(
        1.0, unit="mm", meaning="smallest diameter of a dot that is tried", gt=0, le=5
    )
    max_marker_diameter: float | None = parameter(
        None, unit="mm", meaning="greatest diameter of a dot that is tried; empty: dot alone", gt=0, le=5
    )
    cameras: tuple[CameraChoice, ...] = (CameraChoice(),)
    materials: tuple[str, ...] = parameter(
        ("zaid_2024_ecoflex_00_30",), unit="", meaning="elastomers that may be cast, as in a study's material"
    )
    objectives: tuple[Objective, ...] = parameter(
        ("error",), unit="", meaning="what is made least: error, force, markers, price, size; a front where several"
    )
    skins: int = parameter(60, unit="1", meaning="skins that are tried", ge=1, le=100000)
    max_hours: float = parameter(4.0, unit="h", meaning="time after which no further skin is begun", gt=0, le=10000)
    finalists: int = parameter(3, unit="1", meaning="best skins that are pressed at full fidelity", ge=0, le=20)
    validation: Proof = parameter(
        "none",
        unit="",
        meaning="whether winner and rivals are played on the bench: none, played (read by their twins), or trained "
        "(by trained networks as well)",
    )
    baseline: BaselineDesignSpec | None = None
    """A design that the winner is held against in the proof."""
    random_skins: int = parameter(
        0, unit="1", meaning="skins drawn by chance that the search is held against", ge=0, le=100000
    )
    baseline_grid: BaselineGridSpec | None = None
    """Designs that the search is held against as well."""
    tolerance: ToleranceSpec = ToleranceSpec()
    process: ProcessSpec = ProcessSpec()

    @field_validator(*FIELDS)
    @classmethod
    def _ranges_grow(cls, given: Range, info: object) -> Range:
        sizes = {"heights": (2, 60), "base_radii": (5, 60), "thicknesses": (0.2, 15)}
        ratios = {"aspects": (0.2, 5), "tapers": (0.3, 3)}
        name = str(getattr(info, "field_name", ""))
        return _growing(given, *(sizes | ratios)[name], "mm" if name in sizes else "")

    @field_validator("cameras", "materials", "objectives")
    @classmethod
    def _at_least_one(cls, given: tuple[object, ...]) -> tuple[object, ...]:
        if not given:
            raise PydanticCustomError("list-empty", "the list is empty; give at least one.", {})
        names = [item.name if isinstance(item, CameraChoice) else item for item in given]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise PydanticCustomError(
                "list-entry-twice", "{name} stands there twice; keep one.", {"name": str(twice)}
            )
        return given

    @field_validator("materials")
    @classmethod
    def _are_known(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            try:
                get_material(name)
            except PalpateError as error:
                raise PydanticCustomError(error.code, "{says}", {"says": str(error)}) from None
        return names

    @model_validator(mode="after")
    def _can_be_met(self) -> RequirementsSpec:
        """Refuse what contradicts itself; the numbers are named."""
        if self.min_depth >= self.depth:
            _refuse(
                f"min_depth is {self.min_depth:g} mm and depth {self.depth:g} mm; read at less than full depth.",
                "depths-not-rising",
            )
        if self.heights[1] <= self.depth:
            _refuse(
                f"no height up to {self.heights[1]:g} mm can be pressed by {self.depth:g} mm; allow higher skins.",
                "heights-below-depth",
            )
        if self.thicknesses[0] >= self.base_radii[1]:
            _refuse(
                f"walls of {self.thicknesses[0]:g} mm do not fit into a radius of {self.base_radii[1]:g} mm.",
                "wall-thicker-than-radius",
            )
        if self.min_marker_diameter < self.process.min_marker_diameter:
            _refuse(
                f"min_marker_diameter is {self.min_marker_diameter:g} mm, less than that of process, "
                f"{self.process.min_marker_diameter:g} mm.",
                "markers-not-printable",
            )
        if self.max_marker_diameter is not None and self.max_marker_diameter < self.min_marker_diameter:
            _refuse(
                f"max_marker_diameter is {self.max_marker_diameter:g} mm and min_marker_diameter "
                f"{self.min_marker_diameter:g} mm; give the greater one there.",
                "marker-sizes-not-rising",
            )
        if "price" in self.objectives and len(self.cameras) == 1:
            _refuse(
                "price is made least, but there is only one camera; give several or leave price out.",
                "price-without-choice",
            )
        return self


def read_requirements(source: str | Path) -> RequirementsSpec:
    """Read requirements.

    Parameters
    ----------
    source
        Path of a YAML file, or ``"paper_task"``, the task of the paper.

    Raises
    ------
    PalpateError
        If it cannot be read or asks for what cannot be; the message names file and line.
    """
    path = Path(source)
    if str(source) == PRESET and not path.is_file():  # a search leaves a folder of that name
        text = (resources.files("palpate.optimise") / "presets" / f"{PRESET}.yaml").read_text("utf-8")
        return read_spec(Path(f"{PRESET}.yaml"), text, RequirementsSpec, _HINT)
    try:
        text = path.read_text("utf-8")
    except OSError as error:
        raise PalpateError(
            f"The requirements {path} cannot be read: {error.strerror}.", _HINT, code="file-unreadable"
        ) from error
    except UnicodeDecodeError as error:
        raise PalpateError(
            f"{path} is not a text file.", "Give a YAML file in UTF-8.", code="file-not-text"
        ) from error
    return read_spec(path, text, RequirementsSpec, _HINT)


def _growing(given: Range, least: float, most: float, unit: str) -> Range:
    low, high = given
    if not least <= low <= high <= most:
        raise PydanticCustomError(
            "range-malformed",
            "{given} is no range within {bounds}; give the least and the greatest.",
            {"given": f"{low:g} to {high:g}", "bounds": f"{least:g} to {most:g} {unit}".strip()},
        )
    return given


def _refuse(sentence: str, code: str) -> None:
    raise PydanticCustomError(code, "{sentence}", {"sentence": sentence})
