"""Requirements of a design search: task of the sensor, limits of fabrication, search settings."""

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
"""Name of the default camera."""
PRESET = "paper_task"
"""Name of the requirements that the package contains."""
_HINT = f"Give a YAML file, or {PRESET}; see the page on requirements in the documentation."
Objective = Literal["error", "force", "markers", "price", "size"]
Proof = Literal["none", "simulated", "trained"]
FIELDS = {
    "heights": "height",
    "base_radii": "base_radius",
    "thicknesses": "thickness",
    "aspects": "aspect",
    "tapers": "taper",
}
"""Ranges of the search, and the skin field of each."""


class CameraChoice(Spec):
    """Camera that the search can select."""

    name: str = parameter(_CAMERA, unit="", meaning="name of the camera; any other name requires `camera`")
    price: float = parameter(0.0, unit="1", meaning="price of the camera, in one currency for all cameras", ge=0)
    camera: CameraSpec = CameraSpec()
    distances: Range = parameter((40.0, 54.0), unit="mm", meaning="minimum and maximum distance below the base plane")

    @field_validator("distances")
    @classmethod
    def _grows(cls, given: Range) -> Range:
        return _growing(given, 1.0, 1000.0, "mm")

    @model_validator(mode="after")
    def _is_known(self) -> CameraChoice:
        if self.name != _CAMERA and "camera" not in self.model_fields_set:
            raise PydanticCustomError(
                "camera-unknown",
                "the camera {name} has no parameters; give them as camera, or name {known}",
                {"name": self.name, "known": _CAMERA},
            )
        return self


class BaselineDesignSpec(Spec):
    """Design that the winner is compared with, with the first of the cameras and elastomers."""

    height: float = parameter(
        20.0, unit="mm", meaning="height of the inner surface's apex", source=PAPER, ge=2, le=60
    )
    base_radius: float = parameter(
        20.0, unit="mm", meaning="radius of the inner surface's rim", source=PAPER, ge=5, le=60
    )
    thickness: float = parameter(2.0, unit="mm", meaning="skin thickness", source=PAPER, ge=0.2, le=15)
    aspect: float = parameter(1.0, unit="1", meaning="ratio of the meridian's semi-axes; 1: part of a sphere", gt=0)
    markers: MarkerSpec = MarkerSpec()
    distance: float = parameter(
        48.0, unit="mm", meaning="distance of the camera below the base plane", source=PAPER, gt=0, le=1000
    )

    def skin(self) -> SkinSpec:
        """Return the skin of this design."""
        numbers = self.model_dump(include={"height", "base_radius", "thickness"})
        shape = {} if self.aspect == 1.0 else {"kind": "ellipsoid", "aspect": self.aspect}
        return skin_from_data({**shape, **numbers})


class BaselineGridSpec(Spec):
    """Grid of designs that the search is compared with, with the first of the cameras and elastomers."""

    designs: DesignsSpec = DesignsSpec()
    distance: float = parameter(
        48.0, unit="mm", meaning="distance of the camera below the base plane", source=PAPER, gt=0, le=1000
    )

    @field_validator("designs")
    @classmethod
    def _has_rings(cls, given: DesignsSpec) -> DesignsSpec:
        if any(markers.file is not None or markers.rows is not None for markers in given.markers):
            raise PydanticCustomError(
                "layout-not-rings", "the layouts of a baseline grid must be rings; give numbers of markers.", {}
            )
        return given


class RequirementsSpec(Spec):
    """Requirements, constraints and objectives of a search, its settings and its baselines."""

    name: str = Field(
        "search", pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", description="name of the search and its folder"
    )
    seed: int = parameter(0, unit="1", meaning="seed of everything drawn at random", ge=0)
    error_deg: float = parameter(
        0.5, unit="deg", meaning="maximum 95th percentile over built units of the error of rx or ry", gt=0, le=45
    )
    calibration_presses: int = parameter(
        5, unit="1", meaning="calibration presses by which each unit is identified", ge=0, le=100
    )
    min_depth: float = parameter(
        2.4, unit="mm", meaning="minimum depth of the evaluated readings", source=PAPER, ge=0.2
    )
    depth: float = parameter(8.0, unit="mm", meaning="maximum depth of a press", source=PAPER, gt=0, le=40)
    max_tilt_deg: float = parameter(12.0, unit="deg", meaning="maximum tilt of the wall", source=PAPER, ge=2, le=30)
    force_n: float | None = parameter(
        None, unit="N", meaning="maximum force on the workpiece at full depth; empty: no limit", gt=0
    )
    single_state: bool = parameter(
        False, unit="", meaning="whether the skin must have no inverted branch up to full depth"
    )
    heights: Range = parameter((10.0, 30.0), unit="mm", meaning="minimum and maximum height of the inner surface")
    base_radii: Range = parameter((15.0, 20.0), unit="mm", meaning="minimum and maximum radius of the rim")
    thicknesses: Range = parameter((1.0, 4.0), unit="mm", meaning="minimum and maximum skin thickness")
    aspects: Range = parameter(
        (0.6, 1.6), unit="1", meaning="minimum and maximum ratio of the meridian's semi-axes; 1: part of a sphere"
    )
    tapers: Range = parameter(
        (1.0, 1.0), unit="1", meaning="minimum and maximum ratio of rim to apex thickness; 1: even skin"
    )
    markers: int = parameter(169, unit="1", meaning="maximum number of markers", ge=7, le=397)
    min_marker_diameter: float = parameter(1.0, unit="mm", meaning="minimum diameter of a marker", gt=0, le=5)
    max_marker_diameter: float | None = parameter(
        None, unit="mm", meaning="maximum diameter of a marker; empty: only the minimum", gt=0, le=5
    )
    cameras: tuple[CameraChoice, ...] = (CameraChoice(),)
    materials: tuple[str, ...] = parameter(
        ("zaid_2024_ecoflex_00_30",), unit="", meaning="elastomers to choose from, named as in a study's material"
    )
    objectives: tuple[Objective, ...] = parameter(
        ("error",),
        unit="",
        meaning="minimised objectives: error, force, markers, price, size; several give a Pareto front",
    )
    skins: int = parameter(60, unit="1", meaning="number of skins to evaluate", ge=1, le=100000)
    max_hours: float = parameter(4.0, unit="h", meaning="time after which no further skin is started", gt=0, le=10000)
    finalists: int = parameter(
        3, unit="1", meaning="number of best skins that are pressed at full fidelity", ge=0, le=20
    )
    validation: Proof = parameter(
        "none",
        unit="",
        meaning="validation of winner and baselines on the simulated test bench: none, simulated (twins as "
        "estimators), or trained (trained networks as well)",
    )
    baseline: BaselineDesignSpec | None = None
    """Design that the winner is compared with in the validation."""
    random_skins: int = parameter(
        0, unit="1", meaning="number of randomly drawn skins that the search is compared with", ge=0, le=100000
    )
    baseline_grid: BaselineGridSpec | None = None
    """Grid of designs that the search is compared with."""
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
                "list-entry-twice", "{name} is listed twice; keep one entry.", {"name": str(twice)}
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
        """Raise an error that names the values if requirements contradict each other."""
        if self.min_depth >= self.depth:
            _refuse(
                f"min_depth is {self.min_depth:g} mm and depth {self.depth:g} mm; give a smaller min_depth.",
                "depths-not-rising",
            )
        if self.heights[1] <= self.depth:
            _refuse(
                f"the maximum height is {self.heights[1]:g} mm, and depth {self.depth:g} mm; allow higher skins.",
                "heights-below-depth",
            )
        if self.thicknesses[0] >= self.base_radii[1]:
            _refuse(
                f"the minimum thickness, {self.thicknesses[0]:g} mm, exceeds the maximum base radius, "
                f"{self.base_radii[1]:g} mm.",
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
                f"{self.min_marker_diameter:g} mm; exchange them.",
                "marker-sizes-not-rising",
            )
        if "price" in self.objectives and len(self.cameras) == 1:
            _refuse(
                "price is an objective, but only one camera is given; give several cameras or leave price out.",
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
        If the file cannot be read or the requirements contradict each other; the message names file and line.
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
            "{given} is not a range within {bounds}; give minimum and maximum.",
            {"given": f"{low:g} to {high:g}", "bounds": f"{least:g} to {most:g} {unit}".strip()},
        )
    return given


def _refuse(sentence: str, code: str) -> None:
    raise PydanticCustomError(code, "{sentence}", {"sentence": sentence})
