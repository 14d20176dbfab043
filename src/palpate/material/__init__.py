"""Material: cured elastomers as nearly incompressible hyperelastic laws, with the pedigree of their numbers."""

from palpate.material.choose import get_material, list_materials, material_from_data
from palpate.material.curve import Curve, Mode, stretches, trace_curve
from palpate.material.law import Law, Ogden, Polynomial, mooney_rivlin, neo_hooke, ogden, yeoh
from palpate.material.material import DEFAULT_BULK_RATIO, Material
from palpate.material.stress import isochoric

__all__ = [
    "DEFAULT_BULK_RATIO",
    "Curve",
    "Law",
    "Material",
    "Mode",
    "Ogden",
    "Polynomial",
    "get_material",
    "isochoric",
    "list_materials",
    "material_from_data",
    "mooney_rivlin",
    "neo_hooke",
    "ogden",
    "stretches",
    "trace_curve",
    "yeoh",
]
