"""The two materials of the reference files, as good as incompressible."""

from __future__ import annotations

from palpate.material import Material, NeoHooke, get_material

BULK_RATIO = 1e5
"""K / mu where the reference is incompressible; 2000 moves the pressure of a sphere inflated threefold by 0.4 %."""

YEOH = get_material("zaid_2024_ecoflex_00_30").with_bulk_ratio(BULK_RATIO)
NEO_HOOKE = Material("neo-Hooke of the same C10", NeoHooke(0.0141156), bulk_ratio=BULK_RATIO)
MATERIALS = {"yeoh_paper": YEOH, "neo_hookean": NEO_HOOKE}
"""By the first letters of their names in the reference files."""
