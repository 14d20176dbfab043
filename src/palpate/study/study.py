"""Study: settings of a run through all stages, in one YAML file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    SerializeAsAny,
    SerializerFunctionWrapHandler,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)
from pydantic_core import PydanticCustomError

from palpate.calibration import ToleranceSpec
from palpate.camera import CameraSpec
from palpate.core import PAPER, PalpateError, Spec, child_seed, parameter
from palpate.datasets import DatasetSpec
from palpate.design import SKINS, Design, MarkerSpec, SkinSpec, skin_from_data
from palpate.fea import OBSTACLES, ObstacleSpec, WallSpec, check_contact
from palpate.learn import LearningSpec
from palpate.material import Material, get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec

Contact = Annotated[str | float, BeforeValidator(check_contact)]


class DesignsSpec(Spec):
    """The designs of a study: every height with every thickness and every marker layout."""

    skin: dict[str, Any] = Field(default={}, description="kind of the skins and its own numbers; empty: domes")
    heights: tuple[float, ...] = parameter((20.0,), unit="mm", meaning="heights of the domes", source=PAPER)
    thicknesses: tuple[float, ...] = parameter((2.0,), unit="mm", meaning="thicknesses of the walls", source=PAPER)
    base_radius: float = parameter(20.0, unit="mm", meaning="base radius of every dome", source=PAPER)
    markers: tuple[MarkerSpec, ...] = parameter(
        (MarkerSpec(),), unit="1", meaning="marker layouts: a count, or a mapping with rings or a file"
    )

    @model_validator(mode="before")
    @classmethod
    def _profile_gives_sizes(cls, values: Any) -> Any:
        """Replace a drawn meridian by its numbers; height and radius are those of the drawing."""
        skin = values.get("skin") if isinstance(values, dict) else None
        if not isinstance(skin, dict) or skin.get("kind") != "profile":
            return values
        try:
            shape = dict(skin_from_data(skin).build().spec_data)
        except PalpateError as error:
            raise PydanticCustomError(error.code, "{says}", {"says": str(error).replace("\n", " ")}) from None
        sizes = {"heights": [shape.pop("height")], "base_radius": shape.pop("base_radius")}
        return {"thicknesses": [shape.pop("thickness")], **values, **sizes, "skin": shape}

    @field_validator("markers", mode="before")
    @classmethod
    def _counts_are_layouts(cls, layouts: Any) -> Any:
        if not isinstance(layouts, list | tuple):
            return layouts
        return [layout if isinstance(layout, dict | MarkerSpec) else {"count": layout} for layout in layouts]

    @field_validator("skin")
    @classmethod
    def _is_a_skin(cls, skin: dict[str, Any]) -> dict[str, Any]:
        try:
            skin_from_data(skin)
        except PalpateError as error:
            raise PydanticCustomError(error.code, "{says}", {"says": str(error).replace("\n", " ")}) from None
        return skin

    @field_validator("heights", "thicknesses", "base_radius")
    @classmethod
    def _sizes_in_bounds(cls, given: Any, info: ValidationInfo) -> Any:
        """Check every size against the bounds that the skin declares."""
        name = {"heights": "height", "thicknesses": "thickness"}.get(str(info.field_name), "base_radius")
        kind = SKINS.get(str(info.data.get("skin", {}).get("kind", "dome")))
        _each_in_bounds(kind, name, given if isinstance(given, tuple) else (given,))
        return given

    def skins(self) -> tuple[SkinSpec, ...]:
        """Return every skin, thicknesses within heights.

        Raises
        ------
        PalpateError
            If the kind of skin is unknown, or a size is out of its bounds.
        """
        base = {**self.skin, "base_radius": self.base_radius}
        return tuple(
            skin_from_data({**base, "height": height, "thickness": thickness})
            for height in self.heights
            for thickness in self.thicknesses
        )


class MaterialSpec(Spec):
    """Elastomer of a skin, and the gel inside."""

    name: str = parameter(
        "zaid_2024_ecoflex_00_30",
        unit="",
        meaning="name in the library, a material file (.yaml), or a law with its constants in MPa: yeoh:C10,C20,C30",
        source=PAPER,
        flag="material",
    )
    bulk_ratio: float | None = parameter(
        None,
        unit="1",
        meaning="bulk modulus over initial shear modulus; empty: that of the material",
        ge=2,
        le=1e7,
    )

    gel: str | None = parameter(
        None,
        unit="",
        meaning="gel inside the skin, bonded to skin and window: a material named as above; empty: hollow skin",
    )

    @field_validator("name", "gel")
    @classmethod
    def _is_known(cls, name: str | None) -> str | None:
        try:
            if name is not None:
                get_material(name)
        except PalpateError as error:
            raise PydanticCustomError(error.code, "{says}", {"says": str(error)}) from None
        return name

    def material(self) -> Material:
        """Return the material with the gel inside."""
        material = get_material(self.name)
        if self.bulk_ratio is not None:
            material = material.with_bulk_ratio(self.bulk_ratio)
        return material if self.gel is None else replace(material, gel=get_material(self.gel))

    def mesh(self, spec: MeshSpec) -> MeshSpec:
        """Return the mesh settings of a skin of this material: filled if it has a gel inside."""
        return spec if self.gel is None else spec.model_copy(update={"filled": True})


class AsBuiltSpec(Spec):
    """Settings of the predicted accuracy of built units, and of the presses of the twin of each skin."""

    contacts: tuple[Contact, ...] = parameter(
        ("no-slip", 2.0, 0.8, 0.3, 0.2),
        unit="1",
        meaning="contact laws of the presses of a twin that reads images, unless the study's wall is frictionless",
        source="docs/design_notes/surrogate.md",
    )
    tilt_step_deg: float = parameter(
        4.0,
        unit="deg",
        meaning="maximum step between the tilts of a twin, which leaves out other tilts of the study; 0: all of them",
        source="docs/design_notes/surrogate.md",
        ge=0,
        le=30,
    )
    calibration_presses: int = parameter(
        5, unit="1", meaning="calibration presses of each unit in the second figures", ge=1, le=100
    )
    inverted: bool = parameter(
        True, unit="", meaning="whether the twin includes the skin's inverted branch, if it exists"
    )
    checks: int = parameter(
        2,
        unit="1",
        meaning="number of validation presses between those of the twin, for its interpolation error",
        ge=0,
        le=20,
    )
    tolerance: ToleranceSpec = ToleranceSpec()

    @field_validator("contacts")
    @classmethod
    def _contacts_have_friction(cls, contacts: tuple[Contact, ...]) -> tuple[Contact, ...]:
        if not contacts or "frictionless" in contacts:
            raise PydanticCustomError(
                "twin-contacts",
                "the contact laws of a twin are {given}: give one or more of no-slip and coefficients above 0; "
                "without friction, make the obstacle frictionless",
                {"given": ", ".join(map(str, contacts)) or "none"},
            )
        return contacts


AZIMUTHS_DEG = (0.0, 30.0, 60.0, 90.0)
"""Azimuths at which a skin with two mirrors is pressed. By hand."""


def _read_obstacle(given: Any) -> Any:
    """An obstacle from the mapping of a file, by its kind."""
    if not isinstance(given, Mapping):
        return given
    kind = str(given.get("kind", "wall"))
    try:
        spec = OBSTACLES.get(kind)
    except PalpateError as error:
        raise PydanticCustomError(error.code, "{says}", {"says": str(error).replace("\n", " ")}) from None
    named = "kind" in spec.model_fields  # a wall names none
    return spec.model_validate({key: value for key, value in given.items() if named or key != "kind"})


class Study(Spec):
    """One project file: designs, presses, camera, dataset and learning."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", description="name of the study and its folder")
    seed: int = parameter(0, unit="1", meaning="seed of everything drawn at random", ge=0)
    designs: DesignsSpec = DesignsSpec()
    material: MaterialSpec = MaterialSpec()
    mesh: MeshSpec = MeshSpec()
    obstacle: Annotated[SerializeAsAny[ObstacleSpec], BeforeValidator(_read_obstacle)] = WallSpec()
    """Obstacle of the presses: a flat wall, or another by its kind, with depth, depth_step and contact."""
    tilts_deg: tuple[float, ...] = parameter(
        (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0), unit="deg", meaning="tilts that are pressed", source=PAPER
    )
    azimuths_deg: tuple[float, ...] = parameter(
        AZIMUTHS_DEG,
        unit="deg",
        meaning="azimuths at which a skin other than a body of revolution is pressed: from 0 to 90 in equal steps",
    )
    offsets_mm: tuple[float, ...] = parameter(
        (), unit="mm", meaning="offsets from the skin's axis at which an obstacle other than a wall is pressed"
    )
    solver: SolverSpec = SolverSpec()
    camera: CameraSpec = CameraSpec()
    dataset: DatasetSpec = DatasetSpec()
    learning: LearningSpec = LearningSpec()
    forces: bool = parameter(
        False,
        unit="",
        meaning="whether trained networks estimate the contact force as well, by presses of the design",
    )
    built: AsBuiltSpec | None = AsBuiltSpec()
    """Settings of the predicted accuracy of built units; null: no prediction."""

    @field_validator("tilts_deg", "offsets_mm")
    @classmethod
    def _positions_in_bounds(cls, positions: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        if not all(a < b for a, b in pairwise(positions)):
            raise PydanticCustomError(
                "positions-not-ascending", "{name} must be ascending, each once.", {"name": info.field_name}
            )
        obstacle = info.data.get("obstacle")  # missing if it was refused
        if obstacle is None or info.field_name != positions_field(obstacle):
            return positions
        others = {name: getattr(obstacle, name) for name in obstacle.model_fields_set}
        return _each_in_bounds(type(obstacle), obstacle.position_name, positions, others)

    @field_validator("azimuths_deg")
    @classmethod
    def _azimuths_go_round(cls, azimuths: tuple[float, ...]) -> tuple[float, ...]:
        even = [90.0 * k / max(len(azimuths) - 1, 1) for k in range(len(azimuths))]
        if len(azimuths) < 2 or max(abs(a - b) for a, b in zip(azimuths, even, strict=True)) > 1e-6:
            raise PydanticCustomError(
                "azimuths-uneven", "azimuths must go from 0 to 90 in equal steps, such as 0, 30, 60, 90.", {}
            )
        return azimuths

    @model_serializer(mode="wrap")
    def _leave_out_defaults(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out azimuths and offsets that are not given."""
        content: dict[str, Any] = dump(self)
        unsaid = {"azimuths_deg": self.azimuths_deg == AZIMUTHS_DEG, "offsets_mm": not self.offsets_mm}
        return {name: value for name, value in content.items() if not unsaid.get(name)}

    @field_validator("obstacle")
    @classmethod
    def _positions_belong_to_the_study(cls, obstacle: ObstacleSpec) -> ObstacleSpec:
        for name in sorted({obstacle.position_name, "azimuth_deg", "unload"} & obstacle.model_fields_set):
            raise PydanticCustomError(
                "obstacle-position-given",
                "{name} cannot be set here: the study presses to full depth at each of {positions}, and one press "
                "serves every azimuth, unless azimuths_deg is given.",
                {"name": name, "positions": positions_field(obstacle)},
            )
        if obstacle.position_name not in type(obstacle).model_fields:
            raise PydanticCustomError(
                "obstacle-without-position",
                "{label} has no field {name} for a study to vary; press it by `palpate press`.",
                {"label": obstacle.label, "name": obstacle.position_name},
            )
        return obstacle

    @model_validator(mode="after")
    def _other_parts_fit_the_obstacle(self) -> Self:
        """Reject keys that need a wall."""
        if self.obstacle.pose_space.is_tilt:
            return self
        given = {
            "built": self.built is not None and "built" in self.model_fields_set,
            "forces": self.forces,
            "dataset.max_tilt_deg": "max_tilt_deg" in self.dataset.model_fields_set,
        }
        for name in (name for name, chosen in given.items() if chosen):
            raise PydanticCustomError(
                "key-needs-wall",
                "{name} needs a wall, and the obstacle is {label}; leave it out. Offsets reach as far as offsets_mm.",
                {"name": name, "label": self.obstacle.label},
            )
        return self

    @model_validator(mode="after")
    def _positions_are_those_of_the_obstacle(self) -> Self:
        field = positions_field(self.obstacle)
        other = "offsets_mm" if field == "tilts_deg" else "tilts_deg"
        defaults_fit = field == "tilts_deg" and not self.obstacle.sideways
        other_given = other in self.model_fields_set and getattr(self, other)
        if other_given or not (defaults_fit or field in self.model_fields_set):
            raise PydanticCustomError(
                "positions-of-another-obstacle",
                "{label} is pressed at {field}; give {field}, and leave out {other}.",
                {"label": self.obstacle.label, "field": field, "other": other},
            )
        return self

    def design(self, skin: SkinSpec, markers: MarkerSpec = MarkerSpec()) -> Design:  # noqa: B008  (a spec is frozen)
        """Return the design of one skin and layout, with the camera and the elastomer of the study."""
        return Design(skin, markers, self.camera, self.material.material())

    @property
    def positions(self) -> tuple[float, ...]:
        """Positions at which the obstacle is pressed: tilts in degrees, or offsets in mm."""
        found: tuple[float, ...] = getattr(self, positions_field(self.obstacle))
        return found

    def obstacle_at(self, position: float, **changes: Any) -> ObstacleSpec:
        """Return the obstacle at a position (a tilt in degrees, or an offset in mm), with fields changed."""
        return self.obstacle.model_copy(update={self.obstacle.position_name: position, **changes})

    def with_contact(self, contact: str | float) -> Study:
        """Return the study with another contact law."""
        return self.model_copy(update={"obstacle": self.obstacle.model_copy(update={"contact": contact})})

    def seeded(self) -> Study:
        """Return the study with missing seeds of dataset and learning drawn from its own seed."""
        return self.model_copy(
            update={
                name: spec
                if "seed" in spec.model_fields_set
                else spec.model_copy(update={"seed": child_seed(self.seed, name)})
                for name, spec in (("dataset", self.dataset), ("learning", self.learning))
            }
        )


def single_design_study(skin: SkinSpec, markers: MarkerSpec, material: MaterialSpec) -> Study:
    """Return the study of one design, named by its skin, and by its material if it is not the default."""
    shape = dict(skin.build().spec_data)
    sizes = {name: shape.pop(name) for name in SkinSpec.model_fields}
    designs = DesignsSpec(
        skin=shape,
        heights=(sizes["height"],),
        thicknesses=(sizes["thickness"],),
        base_radius=sizes["base_radius"],
        markers=(markers,),
    )
    words = material.model_dump(exclude_none=True).values() if material != MaterialSpec() else ()
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", "_".join([skin.build().name, *map(str, words)]))
    return Study(name=name, designs=designs, material=material)


def positions_field(obstacle: ObstacleSpec) -> str:
    """Return the field of a study with the positions of an obstacle: ``tilts_deg`` or ``offsets_mm``."""
    return "tilts_deg" if obstacle.pose_space.is_tilt else "offsets_mm"


def _each_in_bounds(
    spec: type[BaseModel], name: str, values: tuple[float, ...], others: Mapping[str, Any] | None = None
) -> tuple[float, ...]:
    """Check every value of a field against its bounds in `spec`, with the values of other fields."""
    if not values:
        raise PydanticCustomError("list-empty", "the list is empty; give at least one value.", {})
    for value in values:
        try:
            spec.model_validate({**(others or {}), name: value})
        except ValidationError as error:
            first = error.errors()[0]
            said = {"value": f"{value:g}", "problem": first["msg"]}
            raise PydanticCustomError(first["type"], "{value}: {problem}", said) from None
    return values
