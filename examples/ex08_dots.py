"""Photograph a dome at rest through a camera that sits askew, find its dots and give each its marker number."""

import matplotlib.pyplot as plt
import numpy as np

from palpate.camera import CameraSpec, RenderSpec, build_camera, flat_marker_outlines, render
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.vision import assign_markers, build_pattern, prepare_detector


def main() -> float:
    dome = build_skin(DomeSpec(height=20, thickness=2))
    layout = place_markers(dome, MarkerSpec(count=91))
    mark = place_orientation_mark(dome, layout)
    dots = np.vstack([layout.positions, mark])
    normals = (dots - [0, 0, dome.center_z]) / np.linalg.norm(dots - [0, 0, dome.center_z], axis=1, keepdims=True)
    askew = build_camera(CameraSpec(offset_x=1.5, tilt_y_deg=3, roll_deg=25))
    image = render(
        askew, flat_marker_outlines(dots, normals, layout.diameter), RenderSpec(noise=3, blur_px=0.7, vignetting=0.3)
    )
    blobs = prepare_detector(image).find(image)
    naming = assign_markers(blobs.positions_px, build_pattern(layout.positions, build_camera().project, mark))
    miss = np.linalg.norm(naming.positions_px - askew.project(layout.positions), axis=1)
    print(f"{naming.found.sum()} of {len(layout)} markers named, turned by {naming.turn_deg:.1f} deg")
    print(f"centres off by {miss.mean():.3f} px, at most {miss.max():.3f} px; ambiguous: {naming.ambiguous}")
    figure, axis = plt.subplots(figsize=(6, 4.5), layout="constrained")
    axis.imshow(image, cmap="gray", vmin=0, vmax=255)
    for number, (x, y) in enumerate(naming.positions_px):
        axis.annotate(str(number), (x, y), color="#ffb000", fontsize=6, ha="center", va="center")
    axis.set_axis_off()
    figure.savefig("ex08_dots.svg")
    return float(miss.max())


if __name__ == "__main__":
    main()
