"""Configuration of a dataset."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, field_validator, model_serializer
from pydantic_core import PydanticCustomError

from palpate.core import PalpateError, Spec, parameter
from palpate.fea import check_contact, obstacle_from_data


class RandomisationSpec(Spec):
    """Domain randomisation: deviations of simulated units, drawn for each virtual press.

    Deviations change only the marker displacements since the rest image, as for a real sensor: at rest, each unit
    looks as designed.
    """

    frictions: tuple[float, ...] = parameter(
        (),
        unit="1",
        meaning="additional coefficients of friction; units have any value between these and that of the wall",
    )
    thickness: float = parameter(
        0.0,
        unit="mm",
        meaning="maximum deviation of the skin thickness, both ways",
        ge=0,
        le=1,
    )
    obstacles: tuple[dict[str, Any], ...] = Field(
        default=(),
        description="further obstacles, each by its kind and numbers; a virtual press has one of them or the study's",
    )
    dot: float = parameter(0.0, unit="mm", meaning="maximum print error of a marker, both ways", ge=0, le=2)
    camera_offset: float = parameter(0.0, unit="mm", meaning="maximum offset of the camera along x and y", ge=0, le=5)
    camera_distance: float = parameter(0.0, unit="mm", meaning="maximum change of the camera's distance", ge=0, le=10)
    camera_tilt_deg: float = parameter(
        0.0, unit="deg", meaning="maximum tilt of the camera about x and y", ge=0, le=10
    )
    focal: float = parameter(0.0, unit="1", meaning="maximum relative change of the focal length", ge=0, le=0.2)

    @field_validator("frictions")
    @classmethod
    def _frictions_fall(cls, frictions: tuple[float, ...]) -> tuple[float, ...]:
        for friction in frictions:
            check_contact(friction)
        if any(friction < 0.05 for friction in frictions) or len(set(frictions)) < len(frictions):
            raise PydanticCustomError(
                "frictions-malformed", "frictions must be numbers of at least 0.05, each given once.", {}
            )
        return tuple(sorted(frictions, reverse=True))

    @field_validator("obstacles")
    @classmethod
    def _obstacles_are_known(cls, obstacles: tuple[dict[str, Any], ...]) -> tuple[dict[str, Any], ...]:
        try:
            found = [obstacle_from_data(each) for each in obstacles]
        except PalpateError as error:
            raise PydanticCustomError(error.code, "{says}", {"says": str(error).replace("\n", " ")}) from None
        for given, each in zip(obstacles, found, strict=True):
            common = {"depth", "depth_step", "contact", "unload", "azimuth_deg", each.position_name}
            for name in sorted(common & given.keys()):
                raise PydanticCustomError(
                    "obstacle-travel-given",
                    "{name} of {label} is that of the study; leave it out.",
                    {"name": name, "label": each.label},
                )
        kinds = [{"kind": each["kind"]} if "kind" in each else {} for each in obstacles]
        return tuple(
            kind | each.model_dump(mode="json", exclude_unset=True) for kind, each in zip(kinds, found, strict=True)
        )

    @model_serializer(mode="wrap")
    def _leave_out_no_obstacles(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out an empty list of obstacles, so that older artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        return {name: value for name, value in content.items() if name != "obstacles" or value}

    @property
    def varies_camera(self) -> bool:
        """Whether the camera varies."""
        return any((self.camera_offset, self.camera_distance, self.camera_tilt_deg, self.focal))


class DatasetSpec(Spec):
    """Poses of a dataset, disturbances of its images, and split of its presses.

    ``"disc"`` spreads `n_presses` poses evenly over the disc of tilts. ``"paper-91"`` and ``"paper-504"`` are
    the protocols of Zaid et al. 2024: tilts 0 … 12° in steps of 2°, azimuths in steps of 5° over 0 … 60° or 360°.
    """

    poses: Literal["disc", "paper-91", "paper-504"] = parameter("disc", unit="", meaning="protocol of the poses")
    n_presses: int = parameter(
        1200, unit="1", meaning="number of virtual presses of the protocol 'disc'", ge=10, le=100_000
    )
    max_tilt_deg: float = parameter(
        12.0,
        unit="deg",
        meaning="maximum tilt of the protocol 'disc'",
        gt=0,
        le=30,
        source="Zaid et al. 2024",
    )
    dropped_images: int = parameter(
        2, unit="1", meaning="number of images left out after the rest image", ge=0, le=50, source="Zaid et al. 2024"
    )
    jitter_px: float = parameter(
        2.0,
        unit="px",
        meaning="maximum of the uniform jitter of each pixel coordinate",
        ge=0,
        le=20,
        source="Zaid et al. 2024",
    )
    normalisation: Literal["centred", "unit"] = parameter(
        "centred",
        unit="",
        meaning="scaling of image coordinates: to -1 … 1 about the centre, or to 0 … 1 from the corner",
    )
    validation_fraction: float = parameter(
        0.2, unit="1", meaning="share of the presses in the validation set", gt=0, lt=1
    )
    seed: int = parameter(0, unit="1", meaning="seed of poses and split", ge=0)
    randomise: RandomisationSpec | None = None
    """Domain randomisation of the units; `None` for the nominal design."""

    @model_serializer(mode="wrap")
    def _leave_out_defaults(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out an absent randomisation, so that older artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        if self.randomise is None:
            content.pop("randomise", None)
        return content
