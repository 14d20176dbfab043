"""A sensor that reads where a ball presses: presses beside the axis, a small network, its error in mm."""

import palpate as pp
from palpate.camera import build_camera
from palpate.datasets import DatasetSpec, generate_dataset
from palpate.learn import TrainingSpec, evaluate, train


def main() -> float:
    dome, silicone = pp.build_skin(pp.DomeSpec()), pp.get_material("zaid_2024_ecoflex_00_30")
    mesh, layout = pp.mesh_skin(dome, pp.MeshSpec(cells=6)), pp.place_markers(dome, pp.MarkerSpec(count=37))
    balls = [pp.BallSpec(radius=10, offset=mm, depth=4, contact="frictionless") for mm in (0, 2, 4)]
    presses = [pp.solve_press(mesh, silicone, ball) for ball in balls]
    dataset = generate_dataset(presses, layout, build_camera(), DatasetSpec(n_presses=600, jitter_px=0.2))
    estimator = train(dataset, TrainingSpec(width=32, epochs=150, repeats=1))
    errors = evaluate(estimator, dataset)
    for axis, error in errors.by_axis.items():
        print(f"{axis}: RMSE {error.rmse:.3f} mm, at most {error.max:.2f} mm on {errors.images} held-out images")
    return errors.pooled.rmse


if __name__ == "__main__":
    main()
