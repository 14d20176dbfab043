"""The pack of the default design, which three files read."""

import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from needs import needs
from palpate.camera import CameraSpec
from palpate.design import Design, DomeSpec, MarkerSpec
from palpate.fabrication import FabricationPack, ProcessSpec, write_pack
from palpate.material import get_material
from presses import stored_folder


@pytest.fixture(scope="session")
def pack() -> FabricationPack:
    """Pack of a dome with 37 dots, written once; only to be read."""
    needs("build123d")
    design, process = (
        Design(DomeSpec(), MarkerSpec(count=37), CameraSpec(), get_material("zaid_2024_ecoflex_00_30")),
        ProcessSpec(),
    )

    def make(folder: Path) -> None:
        (folder / "pack.pickle").write_bytes(pickle.dumps(write_pack(folder / "pack", design, process)))

    folder = stored_folder("pack", [repr(design.skin_spec)], make)
    return replace(pickle.loads((folder / "pack.pickle").read_bytes()), folder=folder / "pack")
