"""Long cases, and those of published experiments and codes; `palpate verify` has the quick ones."""

from functools import partial

from palpate.verify import Case
from validation import ball, blocks, caps, domes, everted, filled, pads, roofs, shells, spheres, tubes

_SHELL_CODE = "axisymmetric shell code"
_SOLID_CODE = "axisymmetric solid code"
_BRANCHES = {"flat": "flat", "dimple": "inverted"}
"""Branches of a shell between plates: name in the reference and in palpate."""
_ROOFS = "Sabir & Lock 1972, Sze et al. 2004"

LONG_CASES: tuple[Case, ...] = (
    Case("hertz_sphere_plane", "Hertz 1882", ball.hertz),
    *(Case(f"hertz_sphere_{name}", "Hertz 1882", partial(ball.hertz_round, name)) for name in ("ball", "cylinder")),
    Case("sphere_compression", _SOLID_CODE, ball.compression),
    *(
        Case(f"shell_R{ratio:g}_{name}", _SHELL_CODE, partial(shells.against_shell, branch, ratio))
        for branch, name in _BRANCHES.items()
        for ratio in shells.RATIOS
    ),
    *(Case(f"shell_R{ratio:g}_onset", _SHELL_CODE, partial(shells.dimple_onset, ratio)) for ratio in shells.RATIOS),
    *(
        Case(f"shell_limit_{name}", _SHELL_CODE, partial(shells.thin_limit, branch))
        for branch, name in _BRANCHES.items()
    ),
    *(
        Case(f"dome_H{height}_T{thickness}", _SOLID_CODE, partial(domes.flat_branch, height, thickness))
        for height, thickness in domes.FLAT_TO
    ),
    *(
        Case(f"dome_inverted_H{height}_T{thickness}", _SOLID_CODE, partial(domes.inverted_branch, height, thickness))
        for height, thickness in ((20, 1), (20, 2))
    ),
    *(Case(f"calculix_H20_T3_tilt{tilt}", "CalculiX 2.20", partial(domes.calculix, tilt)) for tilt in (0, 10)),
    Case("scaling", "property", ball.scaling),
)
"""Hertz's contact, large compression, shells between plates and domes against other codes, scaling of a sphere."""

PUBLISHED_CASES: tuple[Case, ...] = (
    Case("clamped_cap_ring", "Teng & Rotter 1989, Wood & Zienkiewicz 1977", partial(caps.loaded_cap, "ring")),
    Case("clamped_cap_apex", "Teng & Rotter 1989, Wood & Zienkiewicz 1977", partial(caps.loaded_cap, "apex")),
    Case("clamped_cap_snap", "Budiansky, Dumir & Nath, Teng & Rotter", caps.snapping_pressure),
    Case("clamped_cap_buckling", "Huang, Teng & Rotter 1989", caps.buckling_pressure),
    *(
        Case(f"hinged_roof_{name}", _ROOFS, partial(roofs.hinged_roof, thickness))
        for name, thickness in zip(("thick", "thin"), roofs.THICKNESSES, strict=True)
    ),
    Case("pulled_cylinder", "Sze, Liu & Lo 2004", tubes.pulled_cylinder),
    Case("bistable_cap", "Taffetani et al. 2018, shallow-shell theory", everted.bistable_cap),
    Case("sphere_buckling", "Zoelly 1915, Ubamanyu et al. 2024", spheres.sphere_buckling),
    Case("sphere_point", "Reissner 1946", spheres.sphere_point),
    Case("bonded_disc", "Gent & Lindley 1959, Kelly 1997", blocks.bonded_disc),
    Case("filled_hemisphere", "axisymmetric triangles", filled.filled_hemisphere),
    *(
        Case(f"pressed_pad_{name}", "exact, Lebedev & Ufliand 1958", partial(pads.pressed_pad, name))
        for name in ("ball", "bar")
    ),
)
"""Cases, in the order of the page."""

SLOW = frozenset(case.name for case in LONG_CASES if case.reference != "property") | {
    "clamped_cap_buckling",
    "pulled_cylinder",
    "bistable_cap",
    "sphere_buckling",
    "filled_hemisphere",
}
"""Names of the cases of the slow tier."""
