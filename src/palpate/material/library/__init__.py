"""Materials with a pedigree: one file each, named author-year with the elastomer."""

from palpate.material.library.zaid_2024_ecoflex_00_30 import MATERIAL as zaid_2024_ecoflex_00_30
from palpate.material.material import Material

LIBRARY: dict[str, Material] = {material.name: material for material in (zaid_2024_ecoflex_00_30,)}
