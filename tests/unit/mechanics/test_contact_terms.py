"""Terms of the energy, contact laws, surface and brick: slopes of the energy, uniform fields and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from errors import refused
from palpate.fea import Ball, Plane
from palpate.material import get_material
from palpate.mechanics import SingularMatrixError
from palpate.mechanics.contact import Contact
from palpate.mechanics.element import System, determinant, spatial_gradients
from palpate.mechanics.friction import (
    ContactHistory,
    ContactLaw,
    ContactPair,
    dissipated,
    empty_history,
    return_to_limit,
)
from palpate.mechanics.linear import Pattern, make_linear_solver
from palpate.mechanics.loading import ContactLoading, DeadLoading
from palpate.mechanics.serendipity import BRICK, fill_nodes, shape_brick
from palpate.mechanics.solid import Solid, State
from palpate.mechanics.stress import smallest_stretch, von_mises
from palpate.mechanics.surface import OuterSurface
from palpate.mechanics.term import Assembly, Damping, DeadLoad, Term

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")
PLACES = np.stack(np.meshgrid(*[[0.0, 0.5, 1.0]] * 3, indexing="ij"), -1).transpose(2, 1, 0, 3).reshape(-1, 3)
NODES = PLACES + 0.03 * np.random.default_rng(0).normal(size=PLACES.shape)
CELLS = np.arange(27)[None]
TOP = np.arange(18, 27)[None]
FREE = np.zeros((27, 3), bool)
U = 0.05 * np.random.default_rng(1).normal(size=(27, 3))
LAW = ContactLaw(stiffness=2.0, width=0.05, tangential_stiffness=1.5, friction=0.4)
BALL = Ball(1.6, np.array([0.4, 0.55, 2.5]))


def surface() -> OuterSurface:
    return OuterSurface(NODES, TOP, np.zeros(1, np.int64))


def assembled(term: Term, u: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Energy, force on the obstacle, residual (81,) and dense tangent (81, 81) of a term alone."""
    solid = Solid(NODES, CELLS, ECOFLEX, FREE)
    system = System(np.zeros(len(solid.pattern.column)), np.zeros(NODES.size))
    diagonal = solid.pattern.start[:-1]
    to = Assembly(NODES, solid.free, solid.place, diagonal, solid.nodal_volume, system)
    energy, force = term.assemble(State(u, np.zeros((1, 4))), to)
    upper = solid.pattern.matrix(system.data).toarray()
    return energy, force, system.residual, upper + np.triu(upper, 1).T


def history(limit: float, pull: float = 0.0) -> ContactHistory:
    """Points that stick beside their place on the ball."""
    reach, place = BALL.closest_points(surface().interpolate(NODES + U))
    rng = np.random.default_rng(3)
    normal = BALL.normal_at(place)
    aside = rng.normal(0, 0.03, place.shape)
    aside -= (aside * normal).sum(axis=1)[:, None] * normal
    return ContactHistory(place + aside, normal, np.full(len(reach), limit), np.full(len(reach), pull))


@pytest.mark.parametrize(("limit", "pull"), [(0.0, 0.0), (0.03, 0.0), (1e9, 0.0), (0.03, 0.7), (0.0, 0.7)])
def test_residual_and_tangent_of_contact_are_the_slopes_of_its_energy(limit: float, pull: float) -> None:
    contact = Contact(surface(), LAW, BALL, history(limit, pull))
    state = State(U, np.zeros((1, 4)))
    energy, force, residual, tangent = assembled(contact, U)
    assert energy == pytest.approx(contact.energy(state, NODES), rel=1e-12)
    assert energy > 0
    step, rng = 1e-6, np.random.default_rng(4)
    for _ in range(4):
        way = rng.normal(size=(27, 3))
        ahead, behind = (contact.energy(State(U + k * step * way, state.p), NODES) for k in (1, -1))
        assert (ahead - behind) / (2 * step) == pytest.approx(residual @ way.ravel(), rel=1e-5, abs=1e-9)
        high, low = (assembled(contact, U + k * step * way)[2] for k in (1, -1))
        exact = tangent @ way.ravel()
        assert (high - low) / (2 * step) == pytest.approx(exact, rel=1e-4, abs=2e-4 * np.abs(exact).max())
    assert force == pytest.approx(residual.reshape(-1, 3).sum(axis=0), rel=1e-9)


@pytest.mark.parametrize("reach", [-0.02, 0.0, 0.03, 0.05, 0.2])
def test_the_energy_of_a_plane_is_the_integral_of_its_pressure(reach: float) -> None:
    """A flat face at an even penetration; a lifted one is pulled back by its spring alone."""
    flat = OuterSurface(PLACES, TOP, np.zeros(1, np.int64))
    plane = Plane(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0 - reach]))
    pull = 0.7
    contact = Contact(flat, LAW, plane, empty_history(16)._replace(stabilisation=np.full(16, pull)))
    energy = contact.energy(State(np.zeros((27, 3)), np.zeros((1, 4))), PLACES)
    wanted = quad(lambda d: float(LAW.pressure(np.array(d))), 0, reach)[0] if reach > 0 else pull * reach**2 / 2
    assert energy == pytest.approx(wanted, rel=1e-9, abs=1e-15)
    if reach >= LAW.width:
        assert float(LAW.pressure(np.array(reach))) == pytest.approx(2.0 * (reach - 0.025))


def test_the_limit_of_friction_is_the_pressure_times_its_coefficient() -> None:
    reach = np.array([-1.0, 0.0, 0.03, 0.2])
    assert LAW.friction_limit(reach) == pytest.approx(0.4 * LAW.pressure(reach))
    assert LAW.pressure(reach[:2]).tolist() == [0.0, 0.0]
    assert LAW._replace(friction=np.inf).friction_limit(reach).tolist() == [0.0, 0.0, np.inf, np.inf]


def test_a_spring_beyond_its_limit_slips_to_it_and_its_work_is_lost() -> None:
    plane = Plane(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    points = np.array([[0.1, 0.0, 0.2], [0.0, 0.5, 0.2], [0.3, 0.0, -0.1]])
    before = ContactHistory(
        np.zeros((3, 3)), np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([0.3, 0.3, 0.3]), np.zeros(3)
    )
    after = return_to_limit(LAW, before, ContactPair(points, plane))
    assert after.anchor[0] == pytest.approx([0, 0, 0], abs=1e-12)
    assert after.anchor[1] == pytest.approx([0.0, 0.5 - 0.3 / 1.5, 0.0])
    assert after.limit == pytest.approx(LAW.friction_limit(np.array([0.2, 0.2, -0.1])))
    area = np.array([2.0, 3.0, 0.0])
    assert dissipated(LAW, before, ContactPair(points, plane), area) == pytest.approx(3.0 * 0.3 * (0.5 - 0.2))


def test_dead_loads_and_damping_have_the_slopes_of_their_potentials() -> None:
    rng = np.random.default_rng(5)
    load = DeadLoad(rng.normal(size=(27, 3)), 0.7)
    energy, force, residual, tangent = assembled(load, U)
    assert energy == pytest.approx(-0.7 * np.sum(load.force * U))
    assert residual.reshape(-1, 3) == pytest.approx(-0.7 * load.force)
    assert force == pytest.approx([0, 0, (assembled(replace(load, factor=0.8), U)[0] - energy) / 0.1])
    assert not tangent.any()
    origin = rng.normal(size=(27, 3))
    energy, force, residual, tangent = assembled(Damping(3.0, origin), U)
    volume = np.repeat(Solid(NODES, CELLS, ECOFLEX, FREE).nodal_volume, 3)
    assert (energy, force.tolist()) == (0.0, [0, 0, 0])
    assert residual == pytest.approx(3.0 * volume * (U - origin).ravel())
    assert tangent == pytest.approx(np.diag(3.0 * volume))


def loading(**changes: object) -> ContactLoading:
    return replace(
        ContactLoading(NODES, surface(), LAW, lambda at: BALL.moved(np.array([0.1 * at, 0.0, -at])), True), **changes
    )


@pytest.mark.parametrize(("friction", "share"), [(0.0, 1.5), (0.4, 0.8), (np.inf, 1.0)])
def test_the_edge_of_the_patch_on_a_sphere_advances_by_a_share_of_its_step(friction: float, share: float) -> None:
    path = loading(law=LAW._replace(friction=friction))
    edge, radius, at = 0.01, 20.0, 2.0
    step = path.max_increment(at, edge, radius)
    assert np.sqrt(2 * radius * (at + step)) - np.sqrt(2 * radius * at) == pytest.approx(share * edge, rel=2e-3)
    assert path.remembers == (friction > 0)
    assert DeadLoading(DeadLoad(np.zeros((27, 3)))).max_increment(at, edge, radius) == np.inf


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_power_of_a_path_is_the_slope_of_its_contact_energy(side: float) -> None:
    path, state = loading(), State(U, np.zeros((1, 4)))
    none, step = path.start(), 1e-5
    energies = [path.contact(at, none).energy(state, NODES) for at in (0.1 - step, 0.1 + step)]
    force = np.array([1.0, 2.0, 3.0])
    assert path.power(0.1, state, none, force, side) == pytest.approx(
        (energies[1] - energies[0]) / (2 * step), rel=1e-3
    )
    assert replace(path, aside=False).power(0.1, state, none, force, side) == 3.0
    way = np.array([0.6, 0.0, 0.8])
    assert replace(path, aside=False, way=way).power(0.1, state, none, force, side) == pytest.approx(3.0)
    assert replace(path, way=way).axial_force(force) == pytest.approx(0.6 + 2.4)


def test_points_that_touched_cannot_separate_in_stuck_terms() -> None:
    path, state = loading(), State(U, np.zeros((1, 4)))
    touching = path.touching(0.02, state)
    assert 0 < touching.sum() < len(touching)
    (stuck,) = path.stuck_terms(0.02, 0.02, state, path.start())
    assert stuck.history.stabilisation.tolist() == np.where(touching, LAW.stiffness, 0.0).tolist()
    points = surface().interpolate(NODES + U)
    inside = np.linalg.norm(points - BALL.moved(np.array([0.002, 0.0, -0.02])).point, axis=1) < BALL.radius
    assert touching.tolist() == inside.tolist()


def test_the_outer_surface_has_the_area_and_fields_of_its_face() -> None:
    flat = OuterSurface(PLACES * [2.0, 3.0, 1.0], TOP, np.zeros(1, np.int64))
    assert flat.area == pytest.approx(6.0)
    field = PLACES @ np.random.default_rng(6).normal(size=(3, 3)) + 1.0
    points = flat.interpolate(PLACES)
    assert flat.interpolate(field) == pytest.approx(
        points @ np.linalg.lstsq(np.column_stack([PLACES, np.ones(27)]), field, rcond=None)[0][:3] + 1.0
    )
    assert flat.place(field) == pytest.approx(flat.interpolate(field))
    left = points[:, 0] < 0.5
    weights = flat.faces.weight.ravel()
    assert weights[left].sum() == pytest.approx(3.0)
    turn = Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix()
    assert flat.current_area((PLACES * [4.0, 3.0, 1.0]) @ turn.T, left) == pytest.approx(6.0)
    assert flat.current_area(PLACES, np.zeros(16, bool)) == 0.0


def test_von_mises_stress_is_that_of_tension_and_shear_in_any_axes() -> None:
    assert von_mises(np.array([3.0, 0, 0, 0, 0, 0])) == pytest.approx(3.0)
    assert von_mises(np.array([0.0, 0, 0, 2.0, 0, 0])) == pytest.approx(2.0 * np.sqrt(3))
    assert von_mises(np.array([5.0, 5.0, 5.0, 0, 0, 0])) == 0.0
    rng = np.random.default_rng(7)
    stress = rng.normal(size=(3, 3))
    stress += stress.T
    turn = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    found = []
    for each in (stress, turn @ stress @ turn.T):
        found.append(
            float(von_mises(np.array([each[0, 0], each[1, 1], each[2, 2], each[0, 1], each[1, 2], each[2, 0]])))
        )
    principal = np.linalg.eigvalsh(stress)
    wanted = np.sqrt(sum((principal[i] - principal[i - 1]) ** 2 for i in range(3)) / 2)
    assert found == pytest.approx([wanted, wanted])


def test_the_smallest_stretch_is_that_of_a_uniform_deformation_and_its_place_that_of_a_squeezed_corner() -> None:
    solid = Solid(PLACES, CELLS, ECOFLEX, FREE)
    turn = Rotation.from_rotvec([0.4, 0.2, -0.3]).as_matrix()
    F = turn @ np.diag([1.2, 0.7, 1.1])
    stretch, _ = smallest_stretch(solid, State(PLACES @ F.T - PLACES, np.zeros((1, 4))))
    assert stretch == pytest.approx(0.7)
    squeezed = np.zeros((27, 3))
    squeezed[:, 2] = -0.3 * PLACES[:, 2] ** 2 * PLACES[:, 0]
    stretch, place = smallest_stretch(solid, State(squeezed, np.zeros((1, 4))))
    assert stretch < 0.6
    assert place[[0, 2]] == pytest.approx([0.887, 0.887], abs=1e-3)


def test_the_brick_has_the_shape_functions_of_its_20_nodes() -> None:
    nodes = (2.0 * PLACES - 1.0)[BRICK]
    assert shape_brick(nodes) == pytest.approx(np.eye(20), abs=1e-12)
    local = np.random.default_rng(8).uniform(-1, 1, (9, 3))

    def field(points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        return (
            1 + x - 2 * y + 3 * z + x * y - y * z + 2 * z * x + x * x - 3 * y * y + z * z + x * y * z + x * x * y * z
        )

    assert shape_brick(local) @ field(nodes) == pytest.approx(field(local))
    given = np.stack([field(2.0 * PLACES - 1.0)] * 2, axis=-1)
    damaged = given.copy()
    damaged[np.setdiff1d(np.arange(27), BRICK)] = np.nan
    assert fill_nodes(CELLS, damaged) == pytest.approx(given)


@pytest.mark.parametrize("name", ["pardiso", "rslab", "superlu"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_matrix_with_a_value_that_is_not_finite_is_refused(name: str, value: float) -> None:
    pattern = Pattern(np.array([0, 2, 3]), np.array([0, 1, 1]))
    solver = make_linear_solver(name)
    solver.analyze(pattern)
    with pytest.raises(SingularMatrixError):
        solver.refactor(np.array([2.0, value, 3.0]))
    assert solver.refactor(np.array([2.0, 1.0, -3.0])) in (1, -1)
    assert solver.solve(np.array([3.0, -2.0])) == pytest.approx([1.0, 1.0])


def test_a_backend_that_is_not_installed_is_refused_with_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "rslab" else object())
    with refused("solver-missing", "rslab"):
        make_linear_solver("rslab")


def test_determinant_and_spatial_gradients_are_those_of_the_inverse() -> None:
    rng = np.random.default_rng(9)
    gradient, found = rng.normal(size=(27, 3)), np.empty((27, 3))
    for _ in range(5):
        F = np.eye(3) + 0.5 * rng.normal(size=(3, 3))
        F *= np.sign(np.linalg.det(F))
        assert determinant(F) == pytest.approx(np.linalg.det(F))
        assert spatial_gradients(gradient, F, found) == pytest.approx(np.linalg.det(F))
        assert found == pytest.approx(gradient @ np.linalg.inv(F))
