"""Cases of `palpate verify`: materials, solids, contact, shells, domes, properties."""

from __future__ import annotations

from functools import partial

import palpate.verify.ball as ball
import palpate.verify.bending as bending
import palpate.verify.cook as cook
import palpate.verify.domes as domes
import palpate.verify.fits as fits
import palpate.verify.inflation as inflation
import palpate.verify.laws as laws
import palpate.verify.material as material
import palpate.verify.properties as properties
import palpate.verify.sensitivity as sensitivity
import palpate.verify.shells as shells
from palpate.verify.case import Case

_SHELL_CODE = "axisymmetric shell code"
_SOLID_CODE = "axisymmetric solid code"
_BRANCHES = {"flat": "flat", "dimple": "inverted"}
"""Branches of a shell between plates: name in the reference and in palpate."""

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
"""Cases, in the order of the page. Published experiments and codes are in `tests/validation`."""
