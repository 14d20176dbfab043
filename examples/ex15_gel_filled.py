"""A skin of one's own shape, hollow and filled with a gel, pressed by an edge: what the gel does to the force."""

from dataclasses import replace

import matplotlib.pyplot as plt

import palpate as pp
from palpate.design import skin_from_data
from palpate.fea import obstacle_from_data


def main() -> float:
    skin = skin_from_data(
        {"kind": "spline", "height": 18, "thickness": 1, "points": [[0.5, 0.9]], "taper": 1.5}
    ).build()
    edge = obstacle_from_data(
        {"kind": "edge", "radius": 4, "opening_deg": 120, "depth": 3, "contact": "frictionless"}
    )
    rubber, gel = pp.get_material("neo-hooke:0.1"), pp.get_material("neo-hooke:0.005")
    hollow = pp.solve_press(pp.mesh_skin(skin, pp.MeshSpec(cells=8, core=1)), rubber, edge)
    filled = pp.solve_press(
        pp.mesh_skin(skin, pp.MeshSpec(cells=8, core=1, filled=True)), replace(rubber, gel=gel), edge
    )
    figure, axis = plt.subplots(figsize=(5, 3), layout="constrained")
    for name, press in (("hollow", hollow), ("filled", filled)):
        axis.plot(press.depth, press.force[:, 2], "o-", label=name)
    axis.set(xlabel="travel of the edge, mm", ylabel="force, N")
    axis.legend(frameon=False)
    figure.savefig("ex15_gel_filled.svg")
    ratio = float(filled.force[-1, 2] / hollow.force[-1, 2])
    print(f"The hollow {skin.shape} bears {hollow.force[-1, 2]:.2f} N, filled {ratio:.1f} times as much")
    return ratio


if __name__ == "__main__":
    main()
