"""A sensor that reads how an edge lies: presses beside the axis, a small network, its errors in mm and degrees."""

import numpy as np

import palpate as pp
from palpate.camera import build_camera
from palpate.datasets import DatasetSpec, generate_dataset
from palpate.fea import obstacle_from_data
from palpate.learn import TrainingSpec, train


def main() -> tuple[float, float]:
    dome, silicone = pp.build_skin(pp.DomeSpec()), pp.get_material("zaid_2024_ecoflex_00_30")
    mesh, layout = pp.mesh_skin(dome, pp.MeshSpec(cells=6, core=4)), pp.place_markers(dome, pp.MarkerSpec(count=37))
    edge = {"kind": "edge", "radius": 3, "opening_deg": 120, "depth": 4, "contact": "frictionless"}
    presses = [pp.solve_press(mesh, silicone, obstacle_from_data(edge | {"offset": mm})) for mm in (0, 2, 4)]
    dataset = generate_dataset(presses, layout, build_camera(), DatasetSpec(n_presses=600, jitter_px=0.2))
    estimator = train(dataset, TrainingSpec(width=32, epochs=150, repeats=1))
    held = dataset.subset(validation=True)
    deep = held.poses[:, 2] > 2
    errors = dataset.space.line_error(estimator.predict(held.images_px[deep]), held.poses[deep])
    offset_mm, angle_deg = np.sqrt(np.mean(errors**2, axis=0)).tolist()
    print(f"deeper than 2 mm: offset {offset_mm:.3f} mm, angle {angle_deg:.2f}° RMSE on {deep.sum()} held-out images")
    return offset_mm, angle_deg


if __name__ == "__main__":
    main()
