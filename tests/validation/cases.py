"""Cases that repeat published experiments and codes."""

from functools import partial

from palpate.verify import Case
from validation import blocks, caps, everted, filled, pads, roofs, spheres, tubes

_ROOFS = "Sabir & Lock 1972, Sze et al. 2004"

PUBLISHED_CASES: tuple[Case, ...] = (
    Case("clamped_cap_ring", "Teng & Rotter 1989, Wood & Zienkiewicz 1977", partial(caps.loaded_cap, "ring")),
    Case("clamped_cap_apex", "Teng & Rotter 1989, Wood & Zienkiewicz 1977", partial(caps.loaded_cap, "apex")),
    Case("clamped_cap_snap", "Budiansky, Dumir & Nath, Teng & Rotter", caps.snapping_pressure),
    Case("clamped_cap_buckling", "Huang, Teng & Rotter 1989", caps.buckling_pressure, slow=True),
    *(
        Case(f"hinged_roof_{name}", _ROOFS, partial(roofs.hinged_roof, thickness))
        for name, thickness in zip(("thick", "thin"), roofs.THICKNESSES, strict=True)
    ),
    Case("pulled_cylinder", "Sze, Liu & Lo 2004", tubes.pulled_cylinder, slow=True),
    Case("bistable_cap", "Taffetani et al. 2018, shallow-shell theory", everted.bistable_cap, slow=True),
    Case("sphere_buckling", "Zoelly 1915, Ubamanyu et al. 2024", spheres.sphere_buckling, slow=True),
    Case("sphere_point", "Reissner 1946", spheres.sphere_point),
    Case("bonded_disc", "Gent & Lindley 1959, Kelly 1997", blocks.bonded_disc),
    Case("filled_hemisphere", "axisymmetric triangles", filled.filled_hemisphere, slow=True),
    *(
        Case(f"pressed_pad_{name}", "exact, Lebedev & Ufliand 1958", partial(pads.pressed_pad, name))
        for name in ("ball", "bar")
    ),
)
"""Cases, in the order of the page."""
