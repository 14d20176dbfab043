"""Fabrication pack: the folder for the workshop."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from palpate.design import Finding


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
