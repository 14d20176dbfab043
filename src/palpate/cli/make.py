"""`palpate make`: a fabrication pack for one design."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.camera import CameraSpec
from palpate.cli.design import DesignFlags
from palpate.cli.flag import JsonFlag, default, flag
from palpate.cli.output import print_json
from palpate.design import DomeSpec, MountSpec
from palpate.fabricate import CameraBody, FabricationPack, PackSpec, PadMapping, ProcessSpec, write_pack
from palpate.study import MaterialSpec

_OUT = "New folder for the pack."
_MAPPING = "How the pad carries dots: along the axis, or to equal arcs."
_CAMERA = "Camera that the enclosure is made for."
_MARK = "Print the orientation mark, one dot outside the rings."


@Parameter(name="*")
@dataclass(frozen=True)
class ProcessFlags:
    """How the module is made."""

    material: Annotated[str, flag(MaterialSpec, "name")] = default(MaterialSpec, "name")
    shrinkage: Annotated[float, flag(ProcessSpec, "shrinkage_percent")] = default(ProcessSpec, "shrinkage_percent")
    clearance: Annotated[float, flag(ProcessSpec, "clearance")] = default(ProcessSpec, "clearance")
    mold_wall: Annotated[float, flag(ProcessSpec, "mold_wall")] = default(ProcessSpec, "mold_wall")
    mold_floor: Annotated[float, flag(ProcessSpec, "mold_floor")] = default(ProcessSpec, "mold_floor")
    flange_width: Annotated[float, flag(MountSpec, "flange_width")] = default(MountSpec, "flange_width")
    flange_thickness: Annotated[float, flag(MountSpec, "flange_thickness")] = default(MountSpec, "flange_thickness")
    draft: Annotated[float, flag(MountSpec, "draft_deg")] = default(MountSpec, "draft_deg")
    camera_distance: Annotated[float, flag(CameraSpec, "distance")] = default(CameraSpec, "distance")
    camera: Annotated[CameraBody, Parameter(help=_CAMERA)] = CameraBody.BOARD28
    mapping: Annotated[PadMapping, Parameter(help=_MAPPING)] = PadMapping.AXIS
    mark: Annotated[bool, Parameter(help=_MARK)] = True

    def process(self) -> ProcessSpec:
        """The process of these flags."""
        return ProcessSpec(
            shrinkage_percent=self.shrinkage,
            clearance=self.clearance,
            mold_wall=self.mold_wall,
            mold_floor=self.mold_floor,
            camera_body=self.camera,
            mapping=self.mapping,
            orientation_mark=self.mark,
        )

    def mount(self) -> MountSpec:
        """The flange of these flags."""
        return MountSpec(flange_width=self.flange_width, flange_thickness=self.flange_thickness, draft_deg=self.draft)


def make(
    *,
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    design: DesignFlags | None = None,
    flags: ProcessFlags | None = None,
    json: JsonFlag = False,
) -> None:
    """Write mold, print pattern, enclosure and instructions of one design."""
    design, flags = design or DesignFlags(), flags or ProcessFlags()
    spec = PackSpec(
        dome=DomeSpec(height=design.height, base_radius=design.base_radius, thickness=design.thickness),
        markers=design.marker_spec(),
        mount=flags.mount(),
        material=MaterialSpec(name=flags.material).material(),
        process=flags.process(),
        camera=CameraSpec(distance=flags.camera_distance),
    )
    pack = write_pack(out, spec)
    if json:
        print_json(_describe(pack))
        return
    print(f"{len(pack.files) + 1} files in {pack.folder}; begin with instructions.pdf")
    for finding in pack.findings:
        print(f"{finding.severity}: {finding.message} {finding.remedy}")


def _describe(pack: FabricationPack) -> dict[str, object]:
    return {
        "folder": str(pack.folder),
        "sha256": pack.files,
        "volumes_mm3": pack.volumes,
        "findings": [asdict(finding) for finding in pack.findings],
    }
