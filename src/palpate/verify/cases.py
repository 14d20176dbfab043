"""All cases of the suite, in the order of the page: material, solids, contact, shells, domes, properties."""

from __future__ import annotations

from functools import partial

import palpate.verify.ball as ball
import palpate.verify.bending as bending
import palpate.verify.blocks as blocks
import palpate.verify.caps as caps
import palpate.verify.cook as cook
import palpate.verify.domes as domes
import palpate.verify.everted as everted
import palpate.verify.filled as filled
import palpate.verify.fits as fits
import palpate.verify.inflation as inflation
import palpate.verify.laws as laws
import palpate.verify.material as material
import palpate.verify.pads as pads
import palpate.verify.properties as properties
import palpate.verify.roofs as roofs
import palpate.verify.sensitivity as sensitivity
import palpate.verify.shells as shells
import palpate.verify.spheres as spheres
import palpate.verify.tubes as tubes
from palpate.verify.case import Case

_SHELL_CODE = "axisymmetric shell code"
_SOLID_CODE = "axisymmetric solid code"
_ROOFS = "Sabir & Lock 1972, Sze et al. 2004"
_BRANCHES = {"flat": "flat", "dimple": "inverted"}
"""Branches of a shell between plates: the reference's word and ours."""

CASES: tuple[Case, ...] = (
    Case("yeoh_homogeneous", "exact", material.homogeneous),
    Case("yeoh_simple_shear", "exact", material.simple_shear),
    Case("yeoh_drucker_limits", "exact", material.drucker_limits),
    Case("treloar_parameters", "least squares", fits.treloar_parameters),
    Case("treloar_quality", "least squares", fits.treloar_quality),
    Case("table_2_recovery", "exact", fits.table_2_recovery),
    Case("interval_coverage", "Student's t", fits.interval_coverage),
    Case("one_element", "exact, incompressible", material.one_element),
    Case("one_element_in_shear", "exact", material.one_element_in_shear),
    Case("sphere_inflation", "exact, Ogden 1984", inflation.sphere_pressure),
    Case("sphere_inflation_limit_points", "exact, Ogden 1984", inflation.sphere_limit_points),
    Case("sphere_inflation_wall_profile", "exact, Ogden 1984", inflation.sphere_wall_profile),
    Case("cylinder_inflation", "exact, Ogden 1984", inflation.cylinder_pressure),
    Case("torsion_solid_cylinder", "exact, Rivlin 1949", bending.torsion),
    Case("block_bending", "exact, Rivlin 1949", bending.block_bending),
    Case("elastica", "exact, elastica", bending.cantilever),
    Case("elastica_moment", "exact, elastica", bending.cantilever_moment),
    Case("cook_membrane", "Q2/P1 code", cook.cook_membrane),
    Case("no_locking", "finer mesh", cook.no_locking),
    Case("clamped_cap_ring", "Teng & Rotter 1989, Wood & Zienkiewicz 1977", partial(caps.loaded_cap, "ring")),
    Case("clamped_cap_apex", "Teng & Rotter 1989, Wood & Zienkiewicz 1977", partial(caps.loaded_cap, "apex")),
    Case("clamped_cap_snap", "Budiansky, Dumir & Nath, Teng & Rotter", caps.snapping_pressure),
    Case("clamped_cap_buckling", "Huang, Teng & Rotter 1989", caps.buckling_pressure),
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
    Case("hertz_sphere_plane", "Hertz 1882", ball.hertz, slow=True),
    *(
        Case(f"hertz_sphere_{name}", "Hertz 1882", partial(ball.hertz_round, name), slow=True)
        for name in ("ball", "cylinder")
    ),
    Case("sphere_compression", _SOLID_CODE, ball.compression, slow=True),
    *(
        Case(f"shell_R{ratio:g}_{name}", _SHELL_CODE, partial(shells.against_shell, branch, ratio), slow=True)
        for branch, name in _BRANCHES.items()
        for ratio in shells.RATIOS
    ),
    *(
        Case(f"shell_R{ratio:g}_onset", _SHELL_CODE, partial(shells.dimple_onset, ratio), slow=True)
        for ratio in shells.RATIOS
    ),
    *(
        Case(f"shell_limit_{name}", _SHELL_CODE, partial(shells.thin_limit, branch), slow=True)
        for branch, name in _BRANCHES.items()
    ),
    *(
        Case(f"dome_H{height}_T{thickness}", _SOLID_CODE, partial(domes.flat_branch, height, thickness), slow=True)
        for height, thickness in domes.FLAT_TO
    ),
    *(
        Case(
            f"dome_inverted_H{height}_T{thickness}",
            _SOLID_CODE,
            partial(domes.inverted_branch, height, thickness),
            slow=True,
        )
        for height, thickness in ((20, 1), (20, 2))
    ),
    *(
        Case(f"calculix_H20_T3_tilt{tilt}", "CalculiX 2.20", partial(domes.calculix, tilt), slow=True)
        for tilt in (0, 10)
    ),
    Case("patch", "property", properties.patch),
    Case("contact_patch", "property", properties.contact_patch),
    Case("rigid_motion", "property", properties.rigid_motion),
    Case("zero_energy_modes", "property", properties.zero_energy_modes),
    Case("tangent", "property", properties.tangent),
    Case("newton_rate", "property", properties.newton_rate),
    Case("convergence_order", "property", properties.convergence_order),
    Case("scaling", "property", laws.scaling),
    Case("dome_scaling", "property", laws.dome_scaling),
    Case("mirror", "property", laws.mirror),
    Case("press_derivatives", "property", sensitivity.derivatives),
)
"""The suite."""
