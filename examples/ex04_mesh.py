"""Is the mesh fine enough? Force and markers against the number of elements."""

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, plot_convergence, study_convergence
from palpate.material import get_material
from palpate.mesh import mesh_skin


def main() -> float:
    dome = build_skin(DomeSpec(height=20, thickness=4))
    points = place_markers(dome, MarkerSpec(count=37)).positions
    wall = WallSpec(tilt_deg=5, depth=1.6, contact="frictionless")
    results = study_convergence(mesh_skin(dome), get_material("zaid_2024_ecoflex_00_30"), wall, points, (6, 9, 13))
    for result in results:
        print(f"{result.elements} elements: {result.force:.4f} N, markers {100 * result.marker_error:.2f} % of depth")
    plot_convergence(results).savefig("ex04_mesh.svg")
    return results[1].force_error


if __name__ == "__main__":
    main()
