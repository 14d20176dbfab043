"""From presses to an estimator: dataset, training, its error on presses it never saw, and the limit."""

from palpate.camera import build_camera
from palpate.datasets import DatasetSpec, generate_dataset
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.learn import TrainingSpec, compute_error_bounds, evaluate, pool_bounds, train
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import build_field


def main() -> float:
    dome, silicone = build_skin(DomeSpec(height=20, thickness=3)), get_material("zaid_2024_ecoflex_00_30")
    mesh, layout = mesh_skin(dome, MeshSpec(cells=9)), place_markers(dome, MarkerSpec(count=91))
    walls = [WallSpec(tilt_deg=tilt, depth=4, contact="frictionless") for tilt in (0, 6, 12)]
    presses = [solve_press(mesh, silicone, wall) for wall in walls]
    camera, spec = build_camera(), DatasetSpec(n_presses=1500)
    dataset = generate_dataset(presses, layout, camera, spec)
    estimator = train(dataset, TrainingSpec(epochs=80, repeats=1))
    clean, jittered = evaluate(estimator, dataset), evaluate(estimator, dataset, jitter_seed=0)
    limit = pool_bounds(compute_error_bounds(build_field(presses, layout), camera, spec))
    print(f"clean {clean.rmse_deg:.3f} deg, at most {clean.pooled.max:.2f} deg on {clean.images} held-out images")
    print(f"jittered {jittered.rmse_deg:.3f} deg, {jittered.rmse_deg / limit.least_squares_deg:.2f} of least squares")
    return jittered.rmse_deg


if __name__ == "__main__":
    main()
