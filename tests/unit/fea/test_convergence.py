"""Convergence study of a press."""

from types import SimpleNamespace

import numpy as np
import pytest

from errors import refused
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, plot_convergence, study_convergence
from palpate.fea.convergence import _deepest_shared
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin

MATERIAL = get_material("zaid_2024_ecoflex_00_30")
DOME = build_skin(DomeSpec(height=20, thickness=4))
POINTS = place_markers(DOME, MarkerSpec(count=7)).positions
MESH = mesh_skin(DOME, MeshSpec(core=4))
WALL = WallSpec(contact="frictionless", depth=1.6)


@pytest.fixture(scope="module")
def results():
    return study_convergence(MESH, MATERIAL, WALL, POINTS, (10, 4, 6, 8))


def test_study_convergence_goes_from_coarse_to_fine_and_its_errors_fall(results) -> None:
    assert [result.cells for result in results] == [4, 6, 8, 10]
    assert results[3].force_error == results[3].marker_error == 0
    assert np.all(np.diff([result.marker_error for result in results]) < 0)
    assert all(abs(result.force_error) < 0.04 for result in results)
    assert results[0].depth == pytest.approx(1.6)
    assert all(result.marker_error <= result.worst_marker_error for result in results)


def test_one_mesh_is_not_a_study() -> None:
    with refused("convergence-few-meshes", "1"):
        study_convergence(MESH, MATERIAL, WALL, POINTS, (8, 8))


def test_plot_convergence_shows_every_mesh_and_the_papers_limit(results) -> None:
    stress, errors = plot_convergence(results).axes
    assert list(stress.lines[0].get_xdata()) == [result.elements for result in results]
    assert stress.lines[0].get_ydata()[-1] == pytest.approx(results[-1].peak_stress)
    assert errors.lines[1].get_ydata() == pytest.approx([100 * abs(result.force_error) for result in results[:-1]])
    assert all("mathdefault" not in label.get_text() for label in errors.get_yticklabels())
    assert len(errors.lines) == 4


def test_presses_that_share_rest_alone_cannot_be_compared() -> None:
    presses = [SimpleNamespace(depth=np.array(depth)) for depth in ([0.0, 0.8, 1.6], [0.0, 0.8 + 1e-9, 2.0])]
    assert _deepest_shared(presses) == pytest.approx(0.8)  # type: ignore[arg-type]
    with refused("presses-share-no-depth"):
        _deepest_shared([presses[0], SimpleNamespace(depth=np.array([0.0, 0.7]))])  # type: ignore[list-item]
