"""Flags of a design and of a built unit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from palpate.cli.flag import flags_of
from palpate.design import DomeSpec, MarkerSpec, build_dome, place_markers

if TYPE_CHECKING:
    from palpate.sensor import Unit

_LENS = "YAML file of `palpate calibrate`; without it, the nominal camera's lens."

DomeFlags = Annotated[DomeSpec, flags_of(DomeSpec, group="Dome")]
MarkerFlags = Annotated[MarkerSpec, flags_of(MarkerSpec, group="Markers")]


@Parameter(name="*")
@dataclass(frozen=True)
class DesignFlags:
    """A dome and its markers."""

    dome: DomeFlags = DomeSpec()
    markers: MarkerFlags = MarkerSpec()


@Parameter(name="*")
@dataclass(frozen=True)
class UnitFlags(DesignFlags):
    """A built sensor: its design, its lens and whether the orientation mark is printed."""

    lens: Annotated[Path | None, Parameter(help=_LENS)] = None
    mark: Annotated[bool, Parameter(help="Whether the orientation mark is printed.")] = True

    def unit(self) -> Unit:
        """The unit of these flags."""
        from palpate.camera import read_calibration
        from palpate.sensor import Unit

        dome = build_dome(self.dome)
        lens = read_calibration(self.lens).camera_spec() if self.lens else None
        return Unit(dome, place_markers(dome, self.markers), marked=self.mark, lens=lens)
