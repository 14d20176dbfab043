"""An ellipsoid's row of a specification grid: press, generate, train, evaluate, in a minute."""

from pathlib import Path
from tempfile import TemporaryDirectory

import palpate as pp

STUDY = """
name: ellipsoid
designs: {skin: {kind: ellipsoid, aspect: 0.8}, heights: [16], thicknesses: [2], markers: [37]}
tilts_deg: [0, 4]
obstacle: {depth: 2.4, contact: frictionless}
mesh: {cells: 8}
dataset: {max_tilt_deg: 4}
learning: {preset: quick}
"""


def main() -> float:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "ellipsoid.yaml"
        path.write_text(STUDY)
        grid = pp.evaluate_grid(pp.run_study(pp.read_study(path), Path(folder) / "results").designs)
        row = grid.designs[0]
        print(f"{row['shape']}: RMSE {row['rmse_deg']:.2f}°, force {row['force_n']:.3f} N")
        return float(row["rmse_deg"])


if __name__ == "__main__":
    main()
