"""Flags of a design and of a built unit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from palpate.cli.flag import flags_of
from palpate.design import DomeSpec, MarkerSpec, SkinSpec, build_skin, place_markers, read_skin

if TYPE_CHECKING:
    from palpate.sensor import Unit

_LENS = "YAML file of `palpate calibrate`; without it, the nominal camera's lens."

_UNIT = "What `palpate identify` wrote about this unit; a twin then reads on its robot's scale."
_SKIN = "Shape of the skin as KIND:NAME=VALUE, for instance ellipsoid:aspect=0.8."
SkinFlag = Annotated[str, Parameter(help=_SKIN, group="Dome")]
DomeFlags = Annotated[DomeSpec, flags_of(DomeSpec, group="Dome")]
MarkerFlags = Annotated[MarkerSpec, flags_of(MarkerSpec, group="Markers")]


@Parameter(name="*")
@dataclass(frozen=True)
class DesignFlags:
    """A skin and its markers."""

    dome: DomeFlags = DomeSpec()
    markers: MarkerFlags = MarkerSpec()
    skin: SkinFlag = "dome"

    def skin_spec(self) -> SkinSpec:
        """The skin of these flags."""
        return read_skin(self.skin, self.dome)


@Parameter(name="*")
@dataclass(frozen=True)
class UnitFlags(DesignFlags):
    """A built sensor: its design, its lens and whether the orientation mark is printed."""

    lens: Annotated[Path | None, Parameter(help=_LENS)] = None
    unit_file: Annotated[Path | None, Parameter(name="--unit", help=_UNIT)] = None
    mark: Annotated[bool, Parameter(help="Whether the orientation mark is printed.")] = True

    def unit(self) -> Unit:
        """The unit of these flags."""
        from palpate.built import read_unit
        from palpate.camera import read_calibration
        from palpate.sensor import Unit

        skin = build_skin(self.skin_spec())
        layout = place_markers(skin, self.markers)
        lens = read_calibration(self.lens).camera_spec() if self.lens else None
        known = read_unit(self.unit_file) if self.unit_file else None
        return Unit(skin, layout, marked=self.mark, lens=lens, known=known)
