"""`palpate accept`: whether a built unit reads recorded presses of known angles within its tolerances."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.camera import read_calibration, read_image
from palpate.cli.design import DesignFlags
from palpate.cli.flag import JsonFlag, default, flag
from palpate.cli.output import print_json
from palpate.core import PalpateError
from palpate.design import place_markers
from palpate.sensor import AcceptSpec

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from palpate.sensor import Truth

OUTSIDE = 1
"""Exit code where a figure is outside its tolerance, as of `palpate verify`."""

_TRUTH = "CSV of the truth: image, press, rx_deg, ry_deg, depth_mm; images lie beside it, press 'rest' is untouched."
_MODEL = "Model of this design, an ONNX file; then the images are read."
_READINGS = "What `palpate live --out` wrote about these images, instead of a model."
_LENS = "YAML file of `palpate calibrate`; without it, the nominal camera's lens."
_OUT = "Folder for the report: accept.pdf, accept.md, accept.json."
_NAME = "Name of the unit in the report."


@Parameter(name="*")
@dataclass(frozen=True)
class AcceptFlags:
    """What `palpate accept` may be told besides the design."""

    lens: Annotated[Path | None, Parameter(help=_LENS)] = None
    mark: Annotated[bool, Parameter(help="Whether the orientation mark is printed.")] = True
    name: Annotated[str, Parameter(help=_NAME)] = "unit"
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None
    rmse: Annotated[float, flag(AcceptSpec, "rmse_deg")] = default(AcceptSpec, "rmse_deg")
    max_error: Annotated[float, flag(AcceptSpec, "max_deg")] = default(AcceptSpec, "max_deg")
    depth_rmse: Annotated[float, flag(AcceptSpec, "depth_rmse")] = default(AcceptSpec, "depth_rmse")
    least_depth: Annotated[float, flag(AcceptSpec, "least_depth")] = default(AcceptSpec, "least_depth")
    without_pose: Annotated[float, flag(AcceptSpec, "without_pose")] = default(AcceptSpec, "without_pose")
    zero: Annotated[bool, Parameter(help="Whether the depth's zero is found from the first press.")] = True
    guard: Annotated[bool, flag(AcceptSpec, "guard")] = False

    def spec(self) -> AcceptSpec:
        """The spec of these flags."""
        same = ("depth_rmse", "least_depth", "without_pose", "zero", "guard")
        chosen: dict[str, Any] = {name: getattr(self, name) for name in same}
        return AcceptSpec(rmse_deg=self.rmse, max_deg=self.max_error, **chosen)


def accept(
    truth: Annotated[Path, Parameter(help=_TRUTH)],
    *,
    model: Annotated[Path | None, Parameter(help=_MODEL)] = None,
    readings: Annotated[Path | None, Parameter(help=_READINGS)] = None,
    design: DesignFlags | None = None,
    flags: AcceptFlags | None = None,
    json: JsonFlag = False,
) -> int:
    """Tell whether a unit's readings of presses with known angles are within their tolerances."""
    from palpate.sensor import accept_unit, acceptance_page, read_readings, read_truth, write_acceptance

    design, flags = design or DesignFlags(), flags or AcceptFlags()
    if (model is None) == (readings is None):
        raise PalpateError("A unit is judged by a model or by readings.", "Give --model or --readings, one of them.")
    known = read_truth(truth)
    if readings is not None:
        estimates, flagged = read_readings(readings, known)
    else:
        assert model is not None
        estimates, flagged = _read(truth.parent, known, model, (design, flags))
    found = accept_unit(known, estimates, flagged, flags.spec())
    if flags.out is not None:
        write_acceptance(flags.out, found, flags.name)
        print(f"Report: {flags.out / 'accept.pdf'}", file=sys.stderr)
    if json:
        print_json({"unit": flags.name, **found.as_dict()})
    else:
        print(acceptance_page(found, flags.name))
    return 0 if found.passed else OUTSIDE


def _read(
    folder: Path, known: Truth, model: Path, chosen: tuple[DesignFlags, AcceptFlags]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    import numpy as np

    from palpate.learn import open_predictor
    from palpate.sensor import Unit, open_sensor, run_sensor

    design, flags = chosen
    if not known.rest:
        raise PalpateError(
            "The table has no image of the untouched dome.", "Add a row whose press is 'rest' before the others."
        )
    dome = design.dome()
    lens = read_calibration(flags.lens).camera_spec() if flags.lens else None
    unit = Unit(dome, place_markers(dome, design.marker_spec()), marked=flags.mark, lens=lens)
    sensor = open_sensor([read_image(folder / name) for name in known.rest], unit, open_predictor(model))
    found = list(run_sensor(sensor, _images(folder, known.images)))
    poses = np.array([[reading.rx_deg, reading.ry_deg, reading.depth_mm] for reading in found])
    return poses, np.array([bool(reading.flags) for reading in found])


def _images(folder: Path, names: tuple[str, ...]) -> Iterator[NDArray[Any] | PalpateError]:
    for name in names:
        try:
            yield read_image(folder / name)
        except PalpateError as error:
            yield error
