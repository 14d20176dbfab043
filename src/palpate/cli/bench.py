"""`palpate bench`: built units, pressed, photographed and read, with the truth known; and their error budget."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from palpate.bench import ToleranceSpec, VirtualBenchSpec
from palpate.camera import CameraSpec
from palpate.cli.compiling import announce_compilation
from palpate.cli.design import DesignFlags
from palpate.cli.flag import JsonFlag, default, flag
from palpate.cli.output import print_json, print_table
from palpate.core import ArtefactStore, PalpateError
from palpate.design import DomeSpec
from palpate.fea import WallSpec, read_contact
from palpate.study import MaterialSpec

if TYPE_CHECKING:
    from palpate.bench import Bench

_MODEL = "Model of this design, an ONNX file, trained for the nominal camera."
_OUT = "Folder for tables and presses; the same command goes on where it was stopped."
_TOLERANCE = "Tolerances as NAME=VALUE: " + ", ".join(ToleranceSpec.model_fields) + "."
_BUDGET = "Measure every imperfection alone instead of sampled units."
_ZERO = "Whether the depth's zero is found by one press before those that count."
_CLEAN = "Images without uneven light, blur, noise and dirt."


@Parameter(name="*")
@dataclass(frozen=True)
class BenchFlags:
    """How the bench presses and looks."""

    units: Annotated[int, flag(VirtualBenchSpec, "units")] = default(VirtualBenchSpec, "units")
    tilts: Annotated[int, flag(VirtualBenchSpec, "tilts")] = default(VirtualBenchSpec, "tilts")
    azimuths: Annotated[int, flag(VirtualBenchSpec, "azimuths")] = default(VirtualBenchSpec, "azimuths")
    depth: Annotated[float, flag(VirtualBenchSpec, "depth")] = default(VirtualBenchSpec, "depth")
    step: Annotated[float, flag(VirtualBenchSpec, "image_step")] = default(VirtualBenchSpec, "image_step")
    cells: Annotated[int | None, flag(VirtualBenchSpec, "cells")] = None
    solver: Annotated[Literal["palpate", "calculix"], flag(VirtualBenchSpec, "solver")] = "palpate"
    contact: Annotated[str, flag(WallSpec, "contact")] = default(WallSpec, "contact")
    material: Annotated[str, flag(MaterialSpec, "name")] = default(MaterialSpec, "name")
    tolerance: Annotated[tuple[str, ...], Parameter(help=_TOLERANCE, negative="", consume_multiple=True)] = ()
    zero: Annotated[bool, Parameter(help=_ZERO)] = True
    clean: Annotated[bool, Parameter(negative="", help=_CLEAN)] = False
    seed: Annotated[int, flag(VirtualBenchSpec, "seed")] = default(VirtualBenchSpec, "seed")

    def spec(self) -> VirtualBenchSpec:
        """The spec of these flags."""
        from palpate.camera import RenderSpec

        chosen: dict[str, Any] = {"image_step": self.step, "contact": read_contact(self.contact)}
        chosen["tolerance"] = ToleranceSpec.model_validate(dict(_read_pair(text) for text in self.tolerance))
        chosen |= {"render": RenderSpec()} if self.clean else {}
        same = ("units", "tilts", "azimuths", "depth", "cells", "solver", "zero", "seed")
        return VirtualBenchSpec(**{name: getattr(self, name) for name in same}, **chosen)


def bench(
    *,
    model: Annotated[Path, Parameter(help=_MODEL)],
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    design: DesignFlags | None = None,
    flags: BenchFlags | None = None,
    budget: Annotated[bool, Parameter(negative="", help=_BUDGET)] = False,
    json: JsonFlag = False,
) -> None:
    """Play the paper's experiment on built units that deviate from the design within a workshop's tolerances."""
    from palpate.bench import Bench

    design, flags = design or DesignFlags(), flags or BenchFlags()
    dome = DomeSpec(height=design.height, base_radius=design.base_radius, thickness=design.thickness)
    material = MaterialSpec(name=flags.material).material()
    store = ArtefactStore(out / "store")
    played = Bench(flags.spec(), dome, design.marker_spec(), material, CameraSpec(), model, store)
    announce_compilation()
    (_budget if budget else _units)(played, out, json)


def _units(played: Bench, out: Path, json: bool) -> None:
    from palpate.bench import describe_bench, run_bench, write_bench

    results = []
    for result in run_bench(played):
        results.append(result)
        angles = " ".join(f"{s.component} {s.errors.rmse:.3f}/{s.errors.max:.2f}°" for s in result.scores[:2])
        name = f"unit {result.number}" if result.number else "nominal unit"
        _say(f"[{len(results)}/{played.spec.units + 1}] {name}: {result.played.failure or angles}")
        write_bench(out, played, results)
    said = describe_bench(played, results)
    if json:
        print_json(said)
        return
    print((out / "bench.md").read_text(encoding="utf-8").split("## Every unit")[0].strip())
    print(f"\nTables: {out}")


def _budget(played: Bench, out: Path, json: bool) -> None:
    from palpate.bench import describe_budget, run_budget, write_budget

    lines = []
    for line in run_budget(played):
        lines.append(line)
        _say(f"{line.words}: {line.angle_deg:.3f}°")
        write_budget(out, played, lines)
    said = describe_budget(played, lines)
    if json:
        print_json(said)
        return
    names = ["words", "tolerance", "angle_deg", "angle_max_deg", "depth", "units"]
    print_table("error budget", names, [[_text(line[name]) for name in names] for line in said["lines"]])
    print(f"All at once, root of the sum of squares: {said['total_angle_deg']:.3f}°. Tables and chart: {out}")


def _text(value: object) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def _read_pair(text: str) -> tuple[str, str]:
    name, sign, value = text.partition("=")
    if not sign or name not in ToleranceSpec.model_fields:
        raise PalpateError(
            f"The tolerance '{text}' is not known.",
            f"Write NAME=VALUE with one of {', '.join(ToleranceSpec.model_fields)}.",
        )
    return name, value


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
