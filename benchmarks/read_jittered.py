"""Read the jittered images of a data set by the fit of a twin, against the least-squares bound of each pose.

    palpate run best
    palpate calibration predict no_slip.yaml       # a study with built: contacts: [no-slip]
    python benchmarks/read_jittered.py DATASET.h5 H20_T2.h5

Only presses that the data set holds out are read. The unit is the design: all tolerances are nought.
"""

import sys
from pathlib import Path

import numpy as np

from palpate.calibration import PoseFitter, ToleranceSpec, build_unit_model, infer_from_rest
from palpate.camera import CameraSpec
from palpate.datasets import draw_jitter, read_dataset
from palpate.design import TILT_SPACE, MarkerSpec, place_markers
from palpate.surrogate import read_twin


def main(dataset_path: str, twin_path: str) -> None:
    """Print RMSE of rx and ry and what least squares could reach, by depth."""
    dataset, twin = read_dataset(Path(dataset_path)), read_twin(Path(twin_path))
    layout = place_markers(twin.skin, MarkerSpec(count=len(dataset.rest_px)))
    exact = ToleranceSpec(**dict.fromkeys(ToleranceSpec.model_fields, 0.0))
    noise_px = dataset.spec.jitter_px / np.sqrt(3.0)
    model = build_unit_model(
        twin, layout, infer_from_rest(twin, layout, CameraSpec(), dataset.rest_px, exact, 0.01), exact
    )
    held_out = np.flatnonzero(dataset.validation)
    images = draw_jitter(dataset.images_px[held_out], dataset.spec.jitter_px, np.random.default_rng(0))
    fitter, errors, bounds = PoseFitter(model, noise_px), [], []
    for number, image in zip(held_out, images, strict=True):
        pose = dataset.poses[number]
        errors.append(fitter.fit(image).pose[:2] - pose[:2])
        by_pose = model.predict(pose, 0.0, unit=False).pose_jacobian[TILT_SPACE.names].reshape(-1, 3)
        bounds.append(noise_px**2 * np.diag(np.linalg.inv(by_pose.T @ by_pose))[:2])
    squares, least, depths = np.array(errors) ** 2, np.array(bounds), np.round(dataset.poses[held_out, 2], 3)
    print("depth_mm  images  rmse_deg  bound_deg  ratio")
    for depth in (*np.unique(depths), None):
        there = np.ones(len(depths), bool) if depth is None else depths == depth
        rmse, bound = np.sqrt(squares[there].mean()), np.sqrt(least[there].mean())
        print(
            f"{'all' if depth is None else depth:>8}  {there.sum():6}  {rmse:8.4f}  {bound:9.4f}  {rmse / bound:5.3f}"
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
