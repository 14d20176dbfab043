"""`palpate design stability`: the flat and the inverted branch of a dome, by depth and tilt."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.compiling import announce_compilation
from palpate.cli.output import Output
from palpate.cli.press import WallPressFlags
from palpate.core.report import Column, Report

if TYPE_CHECKING:
    from palpate.fea import Stability

_COLUMNS = (
    Column("depth_mm", form=".2f"),
    Column("flat_energy_mj", form=".4f", meaning="potential energy of the flat branch"),
    Column("inverted_energy_mj", form=".4f", meaning="potential energy of the inverted branch"),
    Column("flat_force_n", form=".4f", meaning="contact force of the flat branch"),
    Column("inverted_force_n", form=".4f", meaning="contact force of the inverted branch"),
)
_TILTS = "Tilts of the wall, degrees; by default the value of --tilt."


def stability(
    *,
    flags: WallPressFlags = WallPressFlags(),
    tilts: Annotated[tuple[float, ...], Parameter(help=_TILTS, consume_multiple=True)] = (),
    output: Output = Output(),
) -> None:
    """Follow the flat and the inverted branch of a dome: their ranges of depth, energies and forces."""
    from palpate.fea import find_stability

    walls = [flags.wall.model_validate({**dict(flags.wall), "tilt_deg": tilt}) for tilt in tilts] or [flags.wall]
    mesh, material, _ = flags.problem()
    announce_compilation()
    found = [find_stability(mesh, material, wall) for wall in walls]
    facts = [describe_stability(one) for one in found]
    tables = (Report(f"tilt {one['tilt_deg']:g}°", _COLUMNS, one["depths"], (one["message"],)) for one in facts)
    output.show(facts, *tables)


def describe_stability(found: Stability) -> dict[str, Any]:
    """Return both branches of a dome at one tilt as JSON data; values are NaN if a branch does not exist."""
    columns = {
        "depth_mm": found.depth,
        "flat_energy_mj": found.flat_energy,
        "inverted_energy_mj": found.inverted_energy,
        "flat_force_n": found.flat_force,
        "inverted_force_n": found.inverted_force,
    }
    return {
        "tilt_deg": found.obstacle.radial,
        "inverted_from_mm": found.inverted_from,
        "flat_to_mm": found.flat_to,
        "message": found.message,
        "depths": [{name: float(values[i]) for name, values in columns.items()} for i in range(len(found.depth))],
    }
