"""Fabricate: from a design to the workshop: mold, print pattern, enclosure and instructions."""

from palpate.fabricate.artwork import Artwork, draw_artwork, project_to_page, project_to_skin
from palpate.fabricate.check_process import check_process
from palpate.fabricate.enclosure import Enclosure, build_enclosure
from palpate.fabricate.mesh_file import write_mesh
from palpate.fabricate.mold import Mold, build_mold
from palpate.fabricate.pack import FabricationPack
from palpate.fabricate.spec import CameraBody, PadMapping, ProcessSpec
from palpate.fabricate.specimen import SpecimenMold, build_specimen_molds, write_specimen_molds
from palpate.fabricate.template import build_template
from palpate.fabricate.write_pack import write_pack

__all__ = [
    "Artwork",
    "CameraBody",
    "Enclosure",
    "FabricationPack",
    "Mold",
    "PadMapping",
    "ProcessSpec",
    "SpecimenMold",
    "build_enclosure",
    "build_mold",
    "build_specimen_molds",
    "build_template",
    "check_process",
    "draw_artwork",
    "project_to_page",
    "project_to_skin",
    "write_mesh",
    "write_pack",
    "write_specimen_molds",
]
