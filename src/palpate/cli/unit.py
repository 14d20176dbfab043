"""Flags of a design, of a built unit, and of its model."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.camera import CameraSpec
from palpate.cli.flag import flags_of
from palpate.cli.output import RESULTS
from palpate.core import PalpateError, Spec, flag_name
from palpate.design import Design, DomeSpec, MarkerSpec, SkinSpec, build_skin, read_skin
from palpate.study import MaterialSpec

if TYPE_CHECKING:
    from palpate.sensor import Sensor, Unit

_LENS = "YAML file of `palpate calibration camera`; by default the lens of the nominal camera."

_WINDOW = (
    "Window and gel in front of the camera as THICKNESS,INDEX,GEL_INDEX (mm and refractive indices); by default air."
)
_UNIT = "Unit file of `palpate calibration identify`; a twin then gives poses in the robot's frame."
_SKIN = "Shape of the skin as KIND:NAME=VALUE: ellipsoid:aspect=0.8, or a drawn meridian as profile:file=tip.dxf."
SkinFlag = Annotated[str, Parameter(help=_SKIN, group="Dome")]
DomeFlags = Annotated[DomeSpec, flags_of(DomeSpec, group="Dome")]
MarkerFlags = Annotated[MarkerSpec, flags_of(MarkerSpec, group="Markers")]
MaterialFlags = Annotated[MaterialSpec, flags_of(MaterialSpec, group="Material")]
_MODEL = (
    "Estimator: the twin of the design (.h5), a trained network (.onnx), or model.h5 of `palpate recording train`; "
    "by default the most accurate twin of this design and material in results/*/twins."
)


@Parameter(name="*")
@dataclass(frozen=True)
class SkinFlags:
    """Shape and dimensions of a skin."""

    dome: DomeFlags = DomeSpec()
    skin: SkinFlag = "dome"

    def skin_spec(self) -> SkinSpec:
        """Return the skin of these flags."""
        return read_skin(self.skin, self.dome)


@Parameter(name="*")
@dataclass(frozen=True)
class DesignFlags(SkinFlags):
    """Skin and markers of a design."""

    markers: MarkerFlags = MarkerSpec()

    def design(self, material: MaterialSpec = MaterialSpec(), camera: CameraSpec = CameraSpec()) -> Design:
        """Return the design of these flags."""
        return Design(self.skin_spec(), self.markers, camera, material.material())

    def words(self) -> str:
        """Return these flags as command-line words."""
        skin = "" if self.skin == "dome" else f"--skin {shlex.quote(self.skin)} "
        return skin + _words(self.dome, "height thickness") + _words(self.markers, "count")


@Parameter(name="*")
@dataclass(frozen=True)
class PrintFlags(DesignFlags):
    """Design, lens, window and orientation mark of a built unit."""

    lens: Annotated[Path | None, Parameter(help=_LENS)] = None
    mark: Annotated[bool, Parameter(help="Whether the orientation mark is printed.")] = True
    window: Annotated[str, Parameter(help=_WINDOW)] = ""

    def unit(self, material: MaterialSpec = MaterialSpec()) -> Unit:
        """The unit of these flags."""
        from palpate.camera import read_calibration, read_window
        from palpate.sensor import Unit

        lens = read_calibration(self.lens).camera_spec() if self.lens else None
        if self.window:
            lens = CameraSpec.model_validate(
                (lens or CameraSpec()).model_dump() | {"window": read_window(self.window)}
            )
        return Unit(self.design(material), has_orientation_mark=self.mark, lens=lens)


def open_printing_scale(rest: Iterable[Any], unit: Unit, *words: Any, **flags: Any) -> Sensor:
    """Open a sensor (`open_sensor`), and print if the lens was scaled to the images."""
    from palpate.sensor import open_sensor

    sensor = open_sensor(rest, unit, *words, **flags)
    if scaled := unit.describe_scaling(sensor.registration.camera.spec):
        print(scaled, file=sys.stderr)
    return sensor


@Parameter(name="*")
@dataclass(frozen=True)
class UnitFlags(PrintFlags):
    """Built unit, with the parameters identified from its calibration presses."""

    unit_file: Annotated[Path | None, Parameter(name="--unit", help=_UNIT)] = None

    def unit(self, material: MaterialSpec = MaterialSpec()) -> Unit:
        """The unit of these flags."""
        from palpate.calibration import read_unit

        known = read_unit(self.unit_file) if self.unit_file else None
        return replace(super().unit(material), identified=known)


@Parameter(name="*")
@dataclass(frozen=True)
class ModelFlags:
    """Model of a sensor: a file, or the twin of its design."""

    model: Annotated[Path | None, Parameter(help=_MODEL)] = None
    material: MaterialFlags = MaterialSpec()

    def find(self, design: DesignFlags) -> Path:
        """Return the named file, or the twin of a design with this material.

        Raises
        ------
        PalpateError
            If the named file does not exist, or no file was named and no twin of the design exists.
        """
        if self.model is not None:
            if not self.model.exists():
                raise PalpateError(
                    f"{self.model} does not exist.",
                    "Give the file of a model, or a folder of twins.",
                    code="file-missing",
                )
            return self.model
        skin = build_skin(design.skin_spec())
        from palpate.surrogate import find_twin

        found = find_twin(RESULTS, skin, self.material.material(), _pass_over)
        if found is None:
            material = "" if self.material == MaterialSpec() else f" of {self.material.name}"
            raise PalpateError(
                f"No twin of {skin.name}{material} was found in {RESULTS}/*/twins.",
                "Give --model, or make the twin once (about 3 minutes on one core): palpate calibration predict "
                f"{self.words(design)}",
                code="twin-missing",
            )
        print(f"Model: the twin {found}.", file=sys.stderr)
        return found

    def words(self, design: DesignFlags) -> str:
        """Return design and material as command-line words."""
        return (design.words() + _words(self.material)).strip()


def _pass_over(error: PalpateError) -> None:
    print(f"Skipped: {error.problem}", file=sys.stderr)


def _words(spec: Spec, always: str = "") -> str:
    """Return the flags of a spec whose values differ from the defaults, or that are named in `always`."""
    said = {}
    for name, field in type(spec).model_fields.items():
        value = getattr(spec, name)
        if value != field.default or name in always.split():
            each = value if isinstance(value, tuple) else (value,)
            said[flag_name(type(spec), name)] = " ".join(
                f"{one:g}" if isinstance(one, float) else shlex.quote(str(one)) for one in each
            )
    return "".join(f"--{flag} {value} " for flag, value in said.items())
