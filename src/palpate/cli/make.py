"""`palpate design make`: the fabrication pack of one design."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from palpate.camera import CameraSpec, read_calibration, read_window
from palpate.cli.flag import flags_of
from palpate.cli.output import JsonOutput, check_folder
from palpate.cli.unit import DesignFlags
from palpate.design import Design, MountSpec
from palpate.fabrication import ProcessSpec
from palpate.study import MaterialSpec

if TYPE_CHECKING:
    from palpate.fabrication import FabricationPack

_OUT = "New folder for the pack."
_LENS = "YAML file of `palpate calibration camera`; by default the lens of the nominal camera."
_WINDOW = (
    "Window under a gel-filled skin as THICKNESS,INDEX,GEL_INDEX (mm and refractive indices); by default no window."
)


@Parameter(name="*")
@dataclass(frozen=True)
class PackFlags:
    """Specs of a fabrication pack; each field is a flag."""

    design: DesignFlags = DesignFlags()
    mount: Annotated[MountSpec, flags_of(MountSpec, group="Flange")] = MountSpec()
    material: Annotated[MaterialSpec, flags_of(MaterialSpec, only="name gel", group="Material")] = MaterialSpec()
    process: Annotated[ProcessSpec, flags_of(ProcessSpec, group="Process")] = ProcessSpec()
    camera: Annotated[CameraSpec, flags_of(CameraSpec, only="distance", group="Camera")] = CameraSpec()
    lens: Annotated[Path | None, Parameter(help=_LENS, group="Camera")] = None
    window: Annotated[str, Parameter(help=_WINDOW, group="Camera")] = ""

    def designed(self) -> Design:
        """Return the design of these flags."""
        lens = read_calibration(self.lens).camera_spec() if self.lens else self.camera
        own = {"distance": self.camera.distance} | ({"window": read_window(self.window)} if self.window else {})
        camera = CameraSpec.model_validate(lens.model_dump() | own)
        return self.design.design(self.material, camera)


def make(
    *,
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    flags: PackFlags = PackFlags(),
    output: JsonOutput = JsonOutput(),
) -> None:
    """Write mold, print pattern, enclosure and instructions of one design."""
    from palpate.fabrication import write_pack

    check_folder(out)
    pack = write_pack(out, flags.designed(), flags.process, flags.mount)
    output.show(
        _describe(pack),
        f"{len(pack.files) + 1} files in {pack.folder}; start with instructions.pdf",
        *(f"{finding.severity}: {finding.message} {finding.remedy}" for finding in pack.findings),
    )


def _describe(pack: FabricationPack) -> dict[str, object]:
    return {
        "folder": str(pack.folder),
        "sha256": pack.files,
        "volumes_mm3": pack.volumes,
        "findings": [asdict(finding) for finding in pack.findings],
    }
