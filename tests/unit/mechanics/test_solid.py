"""The element: tangent, rigid motion, patch, zero-energy modes, locking."""

import numpy as np

from palpate.design import DomeSpec, build_skin
from palpate.material import get_material
from palpate.mechanics.element import System
from palpate.mechanics.solid import Solid, State
from palpate.mechanics.stress import cauchy_stress
from palpate.mesh import MeshSpec, mesh_skin

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")


def distorted_cube(seed: int = 0) -> Solid:
    """One free cell, its nodes moved at random."""
    grid = np.stack(np.meshgrid(*[[0.0, 0.5, 1.0]] * 3, indexing="ij"), -1).transpose(2, 1, 0, 3).reshape(-1, 3)
    nodes = grid + 0.03 * np.random.default_rng(seed).normal(size=grid.shape)
    return Solid(nodes, np.arange(27)[None], ECOFLEX, np.zeros((27, 3), bool))


def assemble(solid: Solid, state: State) -> tuple[float, np.ndarray, np.ndarray]:
    """Energy, dense tangent and residual."""
    system = System(np.zeros(len(solid.pattern.column)), np.zeros(solid.nodes.size))
    energy = solid.assemble(state, system)
    upper = solid.pattern.matrix(system.data).toarray()
    return energy, upper + np.triu(upper, 1).T, system.residual


def test_the_tangent_is_the_slope_of_the_residual() -> None:
    solid = distorted_cube()
    rng = np.random.default_rng(1)
    u, direction, step = 0.05 * rng.normal(size=(27, 3)), rng.normal(size=(27, 3)), 1e-6
    p = 1e-3 * rng.normal(size=(1, 4))
    assemble(solid, State(u, p))
    p = p + solid.recover_pressure(np.zeros((27, 3)))
    _, tangent, _ = assemble(solid, State(u, p))
    dp = solid.recover_pressure(step * direction) - solid.recover_pressure(np.zeros((27, 3)))
    ahead = assemble(solid, State(u + step * direction, p + dp))[2]
    behind = assemble(solid, State(u - step * direction, p - dp))[2]
    slope = (ahead - behind) / (2 * step)
    exact = tangent @ direction.ravel()
    assert np.abs(slope - exact).max() < 2e-6 * np.abs(exact).max()


def test_a_free_cell_has_six_zero_energy_modes() -> None:
    solid = distorted_cube()
    _, tangent, _ = assemble(solid, solid.rest())
    values = np.linalg.eigvalsh(tangent)
    assert np.count_nonzero(np.abs(values) < 1e-9 * values[-1]) == 6
    assert values[6] > 1e-7 * values[-1]


def test_a_rigid_motion_raises_no_force() -> None:
    mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=6))
    solid = Solid(mesh.nodes, mesh.cells, ECOFLEX, np.zeros(mesh.nodes.shape, bool))
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = mesh.nodes @ turn.T + [3.0, -2.0, 5.0]
    energy, _, residual = assemble(solid, State(moved - mesh.nodes, solid.rest().p))
    assert np.abs(residual).max() < 1e-12 * ECOFLEX.bulk_modulus * 20
    assert abs(energy) < 1e-12


def test_a_patch_of_distorted_cells_carries_a_uniform_deformation() -> None:
    mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=6))
    F = np.diag([1.3, 1 / 1.3, 1.0]) + np.array([[0, 0.2, 0], [0, 0, 0.1], [0, 0, 0]])
    F /= np.cbrt(np.linalg.det(F))
    fixed = np.ones(mesh.nodes.shape, bool)
    solid = Solid(mesh.nodes, mesh.cells, ECOFLEX, fixed)
    stress = cauchy_stress(solid, State(mesh.nodes @ (F - np.eye(3)).T, solid.rest().p))
    _, tau, _ = ECOFLEX.evaluate(F[None])
    assert np.abs(stress - tau[0]).max() < 1e-8 * np.abs(tau).max()


def test_an_inverted_cell_has_infinite_energy() -> None:
    solid = distorted_cube()
    u = np.zeros((27, 3))
    u[:, 0] = -2 * solid.nodes[:, 0]
    energy = solid.assemble(
        State(u, solid.rest().p), System(np.zeros(len(solid.pattern.column)), np.zeros(solid.nodes.size))
    )
    assert energy == np.inf
