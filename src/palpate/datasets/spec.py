"""What a person may choose about a dataset."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import SerializerFunctionWrapHandler, field_validator, model_serializer
from pydantic_core import PydanticCustomError

from palpate.core import Spec, parameter
from palpate.fea import check_contact


class RandomisationSpec(Spec):
    """How the units behind the training images differ from the design, each virtual press another one.

    What is off is off as the sensor sees it: at rest it looks as designed, for the sensor reads how far the markers
    moved since then.
    """

    frictions: tuple[float, ...] = parameter(
        (),
        unit="1",
        meaning="coefficients of friction that are pressed as well, and all between them and the wall's own",
    )
    thickness: float = parameter(
        0.0,
        unit="mm",
        meaning="a thinner and a thicker wall by this are pressed as well, and all between",
        ge=0,
        le=1,
    )
    dot: float = parameter(0.0, unit="mm", meaning="greatest displacement of a printed dot, both ways", ge=0, le=2)
    camera_offset: float = parameter(
        0.0, unit="mm", meaning="greatest offset of the camera along x and y", ge=0, le=5
    )
    camera_distance: float = parameter(0.0, unit="mm", meaning="greatest change of its distance", ge=0, le=10)
    camera_tilt_deg: float = parameter(
        0.0, unit="deg", meaning="greatest tilt of the camera about x and y", ge=0, le=10
    )
    focal: float = parameter(0.0, unit="1", meaning="greatest change of the focal length, share", ge=0, le=0.2)

    @field_validator("frictions")
    @classmethod
    def _frictions_fall(cls, frictions: tuple[float, ...]) -> tuple[float, ...]:
        for friction in frictions:
            check_contact(friction)
        if any(friction < 0.05 for friction in frictions) or len(set(frictions)) < len(frictions):
            raise PydanticCustomError(
                "frictions-malformed", "frictions are numbers of 0.05 or more, each given once.", {}
            )
        return tuple(sorted(frictions, reverse=True))

    @property
    def varies_camera(self) -> bool:
        """Whether the camera varies."""
        return any((self.camera_offset, self.camera_distance, self.camera_tilt_deg, self.focal))


class DatasetSpec(Spec):
    """Which poses are sampled, what disturbs the images, and which presses are held out.

    ``"disc"`` spreads `n_presses` poses evenly over the disc of tilts. ``"paper-91"`` and ``"paper-504"`` are
    the protocols of Zaid et al. 2024: tilts 0 … 12° by 2°, azimuths by 5° over 0 … 60° or the whole turn.
    """

    poses: Literal["disc", "paper-91", "paper-504"] = parameter(
        "disc", unit="", meaning="protocol that chooses the poses"
    )
    n_presses: int = parameter(1200, unit="1", meaning="virtual presses of the protocol 'disc'", ge=10, le=100_000)
    max_tilt_deg: float = parameter(
        12.0,
        unit="deg",
        meaning="greatest tilt of the protocol 'disc'",
        gt=0,
        le=30,
        source="Zaid et al. 2024",
    )
    dropped_images: int = parameter(
        2, unit="1", meaning="images after rest that are left out", ge=0, le=50, source="Zaid et al. 2024"
    )
    jitter_px: float = parameter(
        2.0,
        unit="px",
        meaning="greatest uniform jitter of each pixel coordinate",
        ge=0,
        le=20,
        source="Zaid et al. 2024",
    )
    normalisation: Literal["centred", "unit"] = parameter(
        "centred", unit="", meaning="image scaled to -1 … 1 about its centre, or to 0 … 1 from its corner"
    )
    validation_fraction: float = parameter(
        0.2, unit="1", meaning="share of the presses held out for validation", gt=0, lt=1
    )
    seed: int = parameter(0, unit="1", meaning="seed of poses and split", ge=0)
    randomise: RandomisationSpec | None = None
    """How the units behind the images differ from the design; nothing, if not given."""

    @model_serializer(mode="wrap")
    def _leave_out_defaults(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Without randomisation a spec is written as before there was any, so that old artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        if self.randomise is None:
            content.pop("randomise", None)
        return content
