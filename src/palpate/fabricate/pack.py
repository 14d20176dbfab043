"""A fabrication pack: the folder that a workshop gets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from palpate.camera import CameraSpec
from palpate.design import Finding, MarkerSpec, MountSpec, SkinSpec
from palpate.fabricate.spec import ProcessSpec
from palpate.material import Material


@dataclass(frozen=True)
class PackSpec:
    """What a pack is made for.

    Attributes
    ----------
    skin, markers, mount
        The design.
    material
        The elastomer.
    process
        How it is made.
    camera
        The camera in the enclosure; its `distance` places it.
    """

    skin: SkinSpec
    markers: MarkerSpec
    mount: MountSpec
    material: Material
    process: ProcessSpec
    camera: CameraSpec


@dataclass(frozen=True)
class FabricationPack:
    """A pack that was written.

    Attributes
    ----------
    folder
        Where.
    files
        Names in it, with their SHA-256.
    volumes
        Volume of every solid, mm³, by name.
    findings
        Limits that the design meets in the workshop; none is an error.
    """

    folder: Path
    files: dict[str, str]
    volumes: dict[str, float]
    findings: tuple[Finding, ...]
