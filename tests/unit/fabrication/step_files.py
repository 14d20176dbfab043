"""What the STEP files of a pack hold."""

import pytest

from palpate.design import CadSolid
from palpate.design.solid import read_step
from palpate.fabrication import FabricationPack


def read_parts(pack: FabricationPack) -> dict[str, CadSolid]:
    """All parts by name; each is valid and has the volume that the pack tells."""
    parts: dict[str, CadSolid] = {}
    for file in ("module", "mold", "enclosure"):
        parts |= read_step(pack.folder / f"{file}.step")
    assert {name: part.volume for name, part in parts.items()} == pytest.approx(pack.volumes, rel=1e-5)
    assert all(part.shape.is_valid for part in parts.values())
    return parts
