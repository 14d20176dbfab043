"""Every model in the elements: a patch, the exact tangent, and a dome under a wall."""

import numpy as np
import pytest

from palpate.design import DomeSpec, build_skin
from palpate.fea import WallSpec, read_press, write_press
from palpate.material import Material, Mode, fit_material, get_material, list_models, trace_curve
from palpate.material.sample import Loading, Sample
from palpate.material.spec import FitSpec
from palpate.mechanics import EndReason, State, System, cauchy_stress
from palpate.mesh import MeshSpec, mesh_skin
from palpate.verify.equilibrium import find_equilibrium, make_solid
from palpate.verify.properties import distorted_cube
from presses import solve_press

LAWS = {
    "neo-hooke": "neo-hooke:0.0141",
    "mooney-rivlin": "mooney-rivlin:0.01,0.004",
    "mooney-rivlin-3": "mooney-rivlin:0.01,0.004,0.001",
    "mooney-rivlin-5": "mooney-rivlin:0.01,0.004,0.0005,0.0004,0.0003",
    "yeoh": "zaid_2024_ecoflex_00_30",
    "gent": "gent:0.0282,30",
    "ogden-1": "ogden:0.02,2.8",
    "ogden-2": "ogden:0.02,2.5,-0.004,-1.5",
    "ogden-3": "ogden:0.02,1.3,0.003,4,-0.004,-2",
    "arruda-boyce": "arruda-boyce:0.027,3",
}


@pytest.fixture(params=LAWS)
def material(request: pytest.FixtureRequest) -> Material:
    return get_material(LAWS[request.param])


def test_every_model_is_pressed_here() -> None:
    assert set(LAWS) == set(list_models())


def test_a_distorted_patch_deforms_homogeneously(material: Material) -> None:
    grid = distorted_cube(2, inside=True)
    surface = np.any([grid.near(axis, value) for axis in range(3) for value in (0.0, 1.0)], axis=0)
    F = np.array([[1.3, 0.2, 0.0], [0.0, 0.9, 0.1], [0.1, 0.0, 0.85]])
    exact = grid.nodes @ (F - np.eye(3)).T
    solid = make_solid(grid, material, np.repeat(surface[:, None], 3, axis=1))
    start = exact + np.where(surface[:, None], 0.0, 0.01 * np.sin(9 * grid.nodes))
    state = find_equilibrium(solid, start, 1e-13 * material.bulk_modulus).state
    J = np.linalg.det(F)
    tau = material.evaluate(F[None])[1][0]
    expected = tau / J + material.bulk_modulus * (J - 1) * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    assert np.abs(state.u - exact).max() < 1e-10
    assert np.abs(cauchy_stress(solid, state) - expected).max() < 1e-8 * np.abs(expected).max()


def test_the_condensed_tangent_is_the_slope_of_the_residual(material: Material) -> None:
    grid = distorted_cube(1, inside=False)
    solid = make_solid(grid, material, np.zeros(grid.nodes.shape, bool))
    rng = np.random.default_rng(1)
    u, direction = 0.03 * rng.normal(size=grid.nodes.shape), rng.normal(size=grid.nodes.shape)

    def assemble(state: State) -> tuple[np.ndarray, np.ndarray]:
        system = System(np.zeros(len(solid.pattern.column)), np.zeros(solid.nodes.size))
        assert np.isfinite(solid.assemble(state, system))
        upper = solid.pattern.matrix(system.data).toarray()
        return upper + np.triu(upper, 1).T, system.residual

    state = State(u, 1e-3 * rng.normal(size=(1, 4)))
    assemble(state)
    state = state.moved(0 * u, solid.recover_pressure(0 * u))
    matrix, _ = assemble(state)
    still = solid.recover_pressure(0 * u)
    slope = np.zeros(u.size)
    for step, weight in ((1e-4, -1 / 3), (0.5e-4, 4 / 3)):
        assemble(state)
        dp = solid.recover_pressure(step * direction) - still
        ahead = assemble(state.moved(step * direction, dp))[1]
        behind = assemble(state.moved(step * direction, dp, -1.0))[1]
        slope += weight * (ahead - behind) / (2 * step)
    exact = matrix @ direction.ravel()
    assert np.abs(slope - exact).max() < 1e-7 * np.abs(exact).max()


def test_a_dome_of_it_is_pressed_and_the_energy_is_the_work(
    material: Material, tmp_path_factory: pytest.TempPathFactory
) -> None:
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=3)), MeshSpec(cells=6))
    press = solve_press(mesh, material, WallSpec(tilt_deg=5, depth=1.6))
    assert press.ended is EndReason.DEPTH_REACHED
    plain = solve_press(
        mesh, get_material(f"neo-hooke:{material.law.shear_modulus / 2!r}"), WallSpec(tilt_deg=5, depth=1.6)
    )
    assert press.force[-1, 2] == pytest.approx(plain.force[-1, 2], rel=0.1)  # strains are small: the modulus decides
    stored = press.energy[-1] + press.contact_energy[-1]
    assert stored == pytest.approx(press.work[-1], rel=2e-2)
    path = tmp_path_factory.mktemp("press") / "press.h5"
    write_press(path, press)
    again = read_press(path).material
    assert again.law == material.law
    assert again.key_data() == material.key_data()


def test_a_stretched_cell_beyond_gents_limit_has_no_finite_energy() -> None:
    grid = distorted_cube(1, inside=True)
    solid = make_solid(grid, get_material("gent:0.0282,1"), np.zeros(grid.nodes.shape, bool))
    stretched = grid.nodes * (np.array([2.0, 2.0**-0.5, 2.0**-0.5]) - 1)
    system = System(np.zeros(len(solid.pattern.column)), np.zeros(solid.nodes.size))
    assert solid.assemble(State(stretched, solid.rest().p), system) == np.inf


def test_a_model_fitted_to_the_papers_curves_presses_like_the_paper() -> None:
    """Fit Ogden's two terms to Yeoh's curves and press both: what a fit misses in stress, a press misses in force."""
    paper = get_material("zaid_2024_ecoflex_00_30")
    samples = [
        Sample(str(loading), loading, stretch, trace_curve(paper, Mode.UNIAXIAL, stretch).nominal)
        for loading, stretch in (
            (Loading.TENSION, np.linspace(1.02, 2, 40)),
            (Loading.COMPRESSION, np.linspace(0.98, 0.6, 30)),
        )
    ]
    fitted = fit_material(samples, FitSpec(model="ogden-2")).material("ogden")
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=3)), MeshSpec(cells=6))
    own, reference = (solve_press(mesh, item, WallSpec(tilt_deg=5, depth=1.6)) for item in (fitted, paper))
    assert own.force[-1] == pytest.approx(reference.force[-1], rel=5e-3, abs=1e-4)
    assert own.displacement[-1] == pytest.approx(reference.displacement[-1], abs=5e-3)
