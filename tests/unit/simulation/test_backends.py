"""One simulated unit by two backends: the twin of its design, and presses solved anew at other poses."""

import numpy as np
import pytest

from palpate.calibration import CONTACT_STATE
from palpate.core.state import State
from palpate.design import Design, DomeSpec, build_skin
from palpate.fea import WallSpec, solve_press
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.simulation import SimulatedUnit, SolverBackend, TwinBackend
from palpate.surrogate import TWIN_DERIVATIVES, build_twin
from small_chain import MARKERS, MATERIAL

SKIN = DomeSpec(height=20, thickness=2)
CELLS = 24
"""A straight press of fewer cells is less alike in all directions than 0.02 mm: 0.05 mm at 9, 0.019 mm at 20."""


@pytest.mark.slow
def test_twin_and_solver_show_the_markers_of_one_unit_within_a_fiftieth_of_a_millimetre() -> None:
    mesh, solver = mesh_skin(build_skin(SKIN), MeshSpec(cells=CELLS)), SolverSpec(derivatives=TWIN_DERIVATIVES)
    walls = [WallSpec(tilt_deg=tilt, depth=4.0, depth_step=0.5) for tilt in (0.0, 2.0, 4.0, 6.0)]
    unit = SimulatedUnit(Design(SKIN, MARKERS, material=MATERIAL))
    by_twin = TwinBackend(unit, build_twin([solve_press(mesh, MATERIAL, wall, solver) for wall in walls]))
    by_solver = SolverBackend(unit, 4.0, cells=CELLS)
    for rx_deg, ry_deg, depth_mm in ((2.5, -1.5, 3.1), (0.0, 3.3, 2.3), (-3.0, 4.0, 3.6)):
        contact = State.zeros(CONTACT_STATE).replace(rx_deg=rx_deg, ry_deg=ry_deg, depth_mm=depth_mm)
        apart = np.linalg.norm(by_twin.edges(contact) - by_solver.edges(contact), axis=2)
        assert apart.max() < 0.02
        assert np.linalg.norm(by_twin.edges(contact) - unit.edges, axis=2).max() > 100 * apart.max()
        assert by_twin.force(contact) == pytest.approx(by_solver.force(contact), rel=0.03, abs=2e-3)
