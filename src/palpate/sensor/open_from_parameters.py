"""Opening of a sensor from named paths, numbers and switches, as another program passes them."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError, field_validator
from pydantic_core import PydanticCustomError

from palpate.calibration import read_unit
from palpate.camera import open_source, read_calibration
from palpate.core import PalpateError, Spec, parameter
from palpate.design import Design, MarkerSpec
from palpate.sensor.sensor import Sensor, open_sensor
from palpate.sensor.spec import SensorSpec
from palpate.sensor.unit import Unit
from palpate.surrogate import read_twin


class SensorLaunchSpec(Spec):
    """Sensor with a twin, and the source of its images."""

    twin: Path = parameter(Path(), unit="", meaning="file of the design's twin, of palpate calibration predict")
    source: str = parameter("0", unit="", meaning="number of a camera, a video, or a folder of images")
    markers: int = parameter(169, unit="1", meaning="number of markers of the design", ge=1)
    layout: Path | None = parameter(None, unit="", meaning="CSV of a free layout, in the place of markers")
    mark: bool = parameter(True, unit="", meaning="whether the orientation mark is printed")
    lens: Path | None = parameter(None, unit="", meaning="YAML file of palpate calibration camera")
    unit: Path | None = parameter(
        None, unit="", meaning="file of the identified unit, of palpate calibration identify"
    )
    rest_images: int = parameter(1, unit="1", meaning="number of rest images at the start", ge=1, le=1000)

    @field_validator("markers")
    @classmethod
    def _is_a_ring_number(cls, count: int) -> int:
        try:
            return MarkerSpec(count=count).count
        except ValidationError as error:
            first = error.errors()[0]
            raise PydanticCustomError(first["type"], "{says}", {"says": first["msg"]}) from None


S = TypeVar("S", bound=SensorLaunchSpec)


def parse_launch_spec(kind: type[S], values: dict[str, Any]) -> S:
    """Build a spec from values by name.

    Raises
    ------
    PalpateError
        If a name is unknown or a value out of bounds.
    """
    try:
        return kind.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        name = ".".join(str(part) for part in first["loc"])
        raise PalpateError(
            f"{Spec.describe_value(first, f'Parameter {name}')}.",
            f"The parameters are {', '.join(kind.model_fields)}.",
            code=first["type"],
        ) from None


def open_from_parameters(spec: SensorLaunchSpec) -> Sensor:
    """Open a sensor by a twin and the first images of a source, which are rest images.

    Raises
    ------
    PalpateError
        If a file or the source cannot be opened, or its first images do not show the unloaded skin of this design.
    """
    twin = read_twin(spec.twin)
    markers = MarkerSpec(file=spec.layout) if spec.layout else MarkerSpec(count=spec.markers)
    lens = read_calibration(spec.lens).camera_spec() if spec.lens else None
    known = read_unit(spec.unit) if spec.unit else None
    unit = Unit(Design.of_skin(twin.skin, markers), spec.mark, lens=lens, identified=known)
    with open_source(spec.source) as source:
        first, clock = list(islice(source.images(), spec.rest_images)), source.clock
    images = [image for image in first if not isinstance(image, PalpateError)]
    if len(images) < spec.rest_images:
        raise PalpateError(
            f"{spec.rest_images} rest images are needed at the start of the source; {len(images)} can be read.",
            "Check the camera, or reduce `rest_images`.",
            code="rest-images-few",
        )
    sensor = open_sensor(images, unit, twin, SensorSpec(rest_images=spec.rest_images))
    sensor.clock = clock
    return sensor
