"""The two materials of the reference files, nearly incompressible."""

from __future__ import annotations

from palpate.material import Material, NeoHooke, get_material

BULK_RATIO = 1e5
"""K / mu for an incompressible reference; 2000 changes the pressure of a sphere at ratio 3 by 0.4 %."""

YEOH = get_material("zaid_2024_ecoflex_00_30").with_bulk_ratio(BULK_RATIO)
NEO_HOOKE = Material("neo-Hooke of the same C10", NeoHooke(0.0141156), bulk_ratio=BULK_RATIO)
MATERIALS = {"yeoh_paper": YEOH, "neo_hookean": NEO_HOOKE}
"""Materials by the first letters of their names in the reference files."""
