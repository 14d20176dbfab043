"""Derivatives of a press: propagation along the load path, and values at the stored increments."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from palpate.core import FloatArray
from palpate.fea.loaded_skin import clamp_skin, load_surface
from palpate.fea.spec import ObstacleSpec
from palpate.fea.variations import PathInputs, make_variations
from palpate.material import Material
from palpate.mechanics import ContactLoading, Continuation, Problem, Sensitivity, Solid, make_linear_solver
from palpate.mesh import Mesh


@dataclass(frozen=True)
class Derivative:
    """Derivative of a press with respect to one parameter, at its increments; nan after a jump.

    Attributes
    ----------
    name
        Name of the parameter; its unit as in `palpate.fea.variations`.
    displacement
        (n, n_nodes, 3) mm over that unit, in the frame of `Press.displacement`, of nodes that keep their position on
        the unit disc and through the thickness.
    force
        (n, 3) N over that unit, of the whole skin, in the skin's frame.
    across
        Whether the field is antisymmetric about the mirror plane of a half model.
    """

    name: str
    displacement: FloatArray
    force: FloatArray
    across: bool = False


def follow_derivatives(path: Continuation, mesh: Mesh, material: Material, obstacle: ObstacleSpec) -> Sensitivity:
    """Follow the derivatives of the solver's spec along a path that begins.

    Raises
    ------
    PalpateError
        If the press cannot be differentiated by a name.
    """
    followed = _prepare(path, mesh, material, obstacle, partial(load_surface, path.spec))
    if followed.variations:
        followed.start(path.last.history)
        path.sensitivity = followed
    return followed


def differentiate_states(
    path: Continuation, increments: Sequence[int], mesh: Mesh, material: Material, wall: ObstacleSpec
) -> Sensitivity:
    """Compute the derivatives at increments of a path without contact history, each independently.

    Raises
    ------
    PalpateError
        If the press cannot be differentiated by a name.
    """
    loading = path.loading
    assert isinstance(loading, ContactLoading)
    points = round(np.sqrt(loading.surface.faces.weight.shape[1]))

    def load(mesh: Mesh, material: Material, wall: ObstacleSpec) -> ContactLoading:
        return replace(load_surface(path.spec, mesh, material, wall, points), law=loading.law)

    followed = _prepare(path, mesh, material, wall, load)
    for number in increments if followed.variations else ():
        point = path.increments[number]
        followed.stand(number, point.depth, point.state, point.history)
    return followed


def _prepare(
    path: Continuation,
    mesh: Mesh,
    material: Material,
    wall: ObstacleSpec,
    load: Callable[[Mesh, Material, ObstacleSpec], ContactLoading],
) -> Sensitivity:
    loading, solid, problem = path.loading, path.problem.body, path.problem
    assert isinstance(loading, ContactLoading)
    assert isinstance(solid, Solid)
    variations = make_variations(PathInputs(mesh, material, wall, load, loading, solid), path.spec.derivatives)
    across = None
    if any(each.antisymmetric for each in variations):
        other, linear = clamp_skin(mesh, material, across=True), make_linear_solver(path.spec.backend)
        across = Problem(other, linear, problem.tolerance, problem.length)
    return Sensitivity(problem, loading, variations, across)


def gather_derivatives(
    followed: Sensitivity, increments: Sequence[int], mesh: Mesh, obstacle: ObstacleSpec
) -> dict[str, Derivative]:
    """Return the derivatives at increments of a path, by name; zero at rest, nan if missing."""
    parts, turn = 1.0 if mesh.spec.whole else 2.0, obstacle.turn(mesh)
    found = {}
    for each in followed.variations:
        sides = np.array([1.0, 0.0, 0.0] if each.antisymmetric else [0.0, 1.0, 1.0]) if parts > 1 else np.ones(3)
        displacement = np.full((len(increments), *mesh.nodes.shape), np.nan)
        force = np.full((len(increments), 3), np.nan)
        for k, number in enumerate(increments):
            if number in followed.found:
                rate = followed.found[number][each.name]
                displacement[k], force[k] = rate.u, turn @ (parts * sides * rate.force)
            elif number == 0:
                displacement[k], force[k] = 0.0, 0.0
        found[each.name] = Derivative(each.name, displacement, force, each.antisymmetric)
    return found
