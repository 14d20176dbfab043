"""Find the depth from which a thin dome can rest in two ways."""

import matplotlib.pyplot as plt

from palpate.design import DomeSpec, build_skin
from palpate.fea import WallSpec, find_stability
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin


def main() -> float:
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=1)), MeshSpec(cells=10))
    found = find_stability(mesh, get_material("zaid_2024_ecoflex_00_30"), WallSpec(depth=4.0, contact="frictionless"))
    print(found.message)
    for depth, flat, inverted in zip(found.depth, found.flat_energy, found.inverted_energy, strict=True):
        print(f"{depth:.2f} mm: flat {flat:.4f} mJ, inverted {inverted:.4f} mJ")
    figure, axis = plt.subplots(figsize=(5, 3), layout="constrained")
    axis.plot(found.depth, found.flat_energy, "o-", label="flat")
    axis.plot(found.depth, found.inverted_energy, "s-", label="inverted")
    axis.set(xlabel="depth, mm", ylabel="energy, mJ")
    axis.legend()
    figure.savefig("ex03_two_states.svg")
    return found.inverted_from


if __name__ == "__main__":
    main()
