"""Fabrication pack: its content, and the folder for the workshop."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from palpate.design import CadSolid, ContactModule, Design, Finding, MountSpec
from palpate.fabrication.artwork import Artwork
from palpate.fabrication.enclosure import LED_WIDTH, Enclosure
from palpate.fabrication.mold import Mold
from palpate.fabrication.spec import ProcessSpec
from palpate.fabrication.window_plate import WindowPlate


@dataclass(frozen=True)
class PackContent:
    """Content of a pack, before it is written; lengths in mm.

    Attributes
    ----------
    design, mount, process
        Inputs of the pack.
    module
        Skin with its flange.
    mold, enclosure, artwork
        Parts made for the module; no artwork without printed markers.
    solids
        Name → part that is written as STL, 3MF and STEP.
    gel
        Name of the gel; empty without one.
    window
        Plate that closes a gel-filled skin.
    """

    design: Design
    mount: MountSpec
    process: ProcessSpec
    module: ContactModule
    mold: Mold
    enclosure: Enclosure
    artwork: Artwork | None
    solids: dict[str, CadSolid]
    gel: str
    window: WindowPlate | None

    @property
    def mixed(self) -> float:
        """Elastomer to mix, mL."""
        return self.mold.hollow() / 1000 * (1 + self.process.excess_percent / 100)

    @property
    def led_radii(self) -> tuple[float, float]:
        """Inner and outer radius of the space for the LEDs, mm."""
        opening = self.module.farthest * self.module.opening_foot
        return opening, opening + LED_WIDTH


@dataclass(frozen=True)
class FabricationPack:
    """Fabrication pack that was written.

    Attributes
    ----------
    folder
        Its folder.
    files
        File names, with their SHA-256.
    volumes
        Volume of every solid, mm³, by name.
    findings
        Limits that the design exceeds in manufacture; none is an error.
    """

    folder: Path
    files: dict[str, str]
    volumes: dict[str, float]
    findings: tuple[Finding, ...]
