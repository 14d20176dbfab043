"""Flags of a design, of a built unit, and of what reads it."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from palpate.camera import CameraSpec
from palpate.cli.flag import flags_of
from palpate.cli.output import RESULTS
from palpate.core import PalpateError, Spec, flag_name
from palpate.design import Design, DomeSpec, MarkerSpec, SkinSpec, build_skin, read_skin
from palpate.study import MaterialSpec

if TYPE_CHECKING:
    from palpate.sensor import Unit

_LENS = "YAML file of `palpate calibration camera`; without it, the nominal camera's lens."

_WINDOW = "Window and gel that the camera looks through, as THICKNESS,INDEX,GEL_INDEX; without it, air."
_UNIT = "What `palpate calibration identify` wrote about this unit; a twin then reads on its robot's scale."
_SKIN = "Shape of the skin as KIND:NAME=VALUE, for instance ellipsoid:aspect=0.8."
SkinFlag = Annotated[str, Parameter(help=_SKIN, group="Dome")]
DomeFlags = Annotated[DomeSpec, flags_of(DomeSpec, group="Dome")]
MarkerFlags = Annotated[MarkerSpec, flags_of(MarkerSpec, group="Markers")]
MaterialFlags = Annotated[MaterialSpec, flags_of(MaterialSpec, group="Material")]
_MODEL = (
    "Model that reads: the twin of the design (.h5), a trained network (.onnx), or model.h5 of "
    "`palpate recording train`; without it, the most accurate twin of this design and material in results/*/twins."
)


@Parameter(name="*")
@dataclass(frozen=True)
class SkinFlags:
    """A skin."""

    dome: DomeFlags = DomeSpec()
    skin: SkinFlag = "dome"

    def skin_spec(self) -> SkinSpec:
        """The skin of these flags."""
        return read_skin(self.skin, self.dome)


@Parameter(name="*")
@dataclass(frozen=True)
class DesignFlags(SkinFlags):
    """A skin and its markers."""

    markers: MarkerFlags = MarkerSpec()

    def design(self, material: MaterialSpec = MaterialSpec(), camera: CameraSpec = CameraSpec()) -> Design:
        """The design of these flags."""
        return Design(self.skin_spec(), self.markers, camera, material.material())

    def words(self) -> str:
        """These flags as they are typed."""
        skin = "" if self.skin == "dome" else f"--skin {shlex.quote(self.skin)} "
        return skin + _words(self.dome, "height thickness") + _words(self.markers, "count")


@Parameter(name="*")
@dataclass(frozen=True)
class PrintFlags(DesignFlags):
    """A sensor as it is seen: its design, its lens and whether the orientation mark is printed."""

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


@Parameter(name="*")
@dataclass(frozen=True)
class UnitFlags(PrintFlags):
    """A built sensor, and what is known of it."""

    unit_file: Annotated[Path | None, Parameter(name="--unit", help=_UNIT)] = None

    def unit(self, material: MaterialSpec = MaterialSpec()) -> Unit:
        """The unit of these flags."""
        from palpate.calibration import read_unit

        known = read_unit(self.unit_file) if self.unit_file else None
        return replace(super().unit(material), identified=known)


@Parameter(name="*")
@dataclass(frozen=True)
class ModelFlags:
    """What a sensor is read with: a file, or the twin of its design."""

    model: Annotated[Path | None, Parameter(help=_MODEL)] = None
    material: MaterialFlags = MaterialSpec()

    def find(self, design: DesignFlags) -> Path:
        """The file that was named, or the twin of a design and this material.

        Raises
        ------
        PalpateError
            If none was named and no twin of the design was made.
        """
        if self.model is not None:
            return self.model
        skin = build_skin(design.skin_spec())
        from palpate.surrogate import find_twin

        found = find_twin(RESULTS, skin, self.material.material(), _pass_over)
        if found is None:
            material = "" if self.material == MaterialSpec() else f" of {self.material.name}"
            raise PalpateError(
                f"There is no twin of {skin.name}{material} in {RESULTS}/*/twins.",
                "Make it once, in some 3 minutes of one core, or give --model: palpate calibration predict "
                f"{self.words(design)}",
                code="twin-missing",
            )
        print(f"Reads by the twin {found}.", file=sys.stderr)
        return found

    def words(self, design: DesignFlags) -> str:
        """Design and material as they are typed."""
        return (design.words() + _words(self.material)).strip()


def _pass_over(error: PalpateError) -> None:
    print(f"Passed over: {error.problem}", file=sys.stderr)


def _words(spec: Spec, always: str = "") -> str:
    """Flags of a spec whose values are not the usual ones, or that are `always` said."""
    said = {}
    for name, field in type(spec).model_fields.items():
        value = getattr(spec, name)
        if value != field.default or name in always.split():
            each = value if isinstance(value, tuple) else (value,)
            said[flag_name(type(spec), name)] = " ".join(
                f"{one:g}" if isinstance(one, float) else shlex.quote(str(one)) for one in each
            )
    return "".join(f"--{flag} {value} " for flag, value in said.items())
