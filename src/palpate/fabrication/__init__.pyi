"""Fabrication: molds, artwork, drawings and instructions of a design."""

from palpate.fabrication.artwork import Artwork, draw_artwork, project_to_page, project_to_skin
from palpate.fabrication.check_process import check_process
from palpate.fabrication.enclosure import Enclosure, build_enclosure
from palpate.fabrication.mesh_file import write_mesh
from palpate.fabrication.mold import Mold, build_mold
from palpate.fabrication.pack import FabricationPack
from palpate.fabrication.spec import CameraBody, PadMapping, ProcessSpec
from palpate.fabrication.specimen import SpecimenMold, build_specimen_molds, write_specimen_molds
from palpate.fabrication.template import build_template
from palpate.fabrication.write_pack import write_pack

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
