"""Cases of `palpate verify`: materials, solids, contact, properties; some 20 CPU-seconds."""

from __future__ import annotations

import palpate.verify.bending as bending
import palpate.verify.cook as cook
import palpate.verify.fits as fits
import palpate.verify.inflation as inflation
import palpate.verify.laws as laws
import palpate.verify.material as material
import palpate.verify.properties as properties
import palpate.verify.sensitivity as sensitivity
from palpate.verify.case import Case

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
    Case("patch", "property", properties.patch),
    Case("contact_patch", "property", properties.contact_patch),
    Case("rigid_motion", "property", properties.rigid_motion),
    Case("zero_energy_modes", "property", properties.zero_energy_modes),
    Case("tangent", "property", properties.tangent),
    Case("newton_rate", "property", properties.newton_rate),
    Case("convergence_order", "property", properties.convergence_order),
    Case("dome_scaling", "property", laws.dome_scaling),
    Case("mirror", "property", laws.mirror),
    Case("press_derivatives", "property", sensitivity.derivatives),
)
"""Cases, in the order of the page; `tests/validation` has long ones and published experiments."""
