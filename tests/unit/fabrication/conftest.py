"""The pack of the default design, which three files read."""

import pytest
from stored_pack import stored_pack

from needs import needs
from palpate.camera import CameraSpec
from palpate.design import Design, DomeSpec, MarkerSpec, MountSpec
from palpate.fabrication import FabricationPack, ProcessSpec
from palpate.material import get_material


@pytest.fixture(scope="session")
def pack() -> FabricationPack:
    """Pack of a dome with 37 dots; only to be read."""
    needs("build123d")
    design = Design(DomeSpec(), MarkerSpec(count=37), CameraSpec(), get_material("zaid_2024_ecoflex_00_30"))
    return stored_pack(design, ProcessSpec(), MountSpec())
