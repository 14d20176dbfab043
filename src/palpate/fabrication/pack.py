"""A fabrication pack: the folder that a workshop gets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from palpate.design import Finding


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
