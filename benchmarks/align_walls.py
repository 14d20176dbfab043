"""Square a drill to random walls by virtual units on a simulated robot, and count; goes on where it was stopped.

    python benchmarks/align_walls.py H20_T2.h5 walls.jsonl
    python benchmarks/align_walls.py H20_T2.h5 walls_unknown.jsonl --calibration-presses 0
    python benchmarks/align_walls.py H20_T2.h5 walls_solved.jsonl --solved --units 4 --walls 5
    python benchmarks/align_walls.py H20_T2.h5 walls.jsonl --count

Each line of the file is a unit with its tool's offset, or a wall. Images are rendered, spoiled and found as on the
bench; where the dots are is the twin's, or with --solved that of presses solved for every touch.
"""

import argparse
import csv
import json
from pathlib import Path

import numpy as np

from palpate.core import PalpateError
from palpate.design import Design, DomeSpec, MarkerSpec
from palpate.simulation import AlignmentScenario, VirtualUnit, describe_wall
from palpate.surrogate import read_twin

ROBOT_DEG = 0.05
"""Of the robot's turns, about each axis."""


def read_lines(path: Path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def play(chosen: argparse.Namespace) -> None:
    dome = DomeSpec(height=20, thickness=2)
    twin = read_twin(chosen.twin)
    played = AlignmentScenario(
        twin,
        Design(dome, MarkerSpec(count=169)),
        calibration_presses=chosen.calibration_presses,
        by_solver=chosen.solved,
    )
    done = {(line["unit"], line.get("wall")) for line in read_lines(chosen.out)}
    for number in range(1, chosen.units + 1):
        if all((number, wall) in done for wall in (None, *range(chosen.walls))):
            continue
        with chosen.out.open("a") as file:
            try:
                unit = VirtualUnit(played, number)
            except PalpateError as error:
                file.write(json.dumps({"unit": number, "failure": str(error)}) + "\n")
                continue
            if (number, None) not in done:
                line = {"unit": number, "offset_error_deg": unit.offset_error_deg, "touches": unit.offset_touches}
                file.write(json.dumps(line) + "\n")
            for wall in range(chosen.walls):
                if (number, wall) not in done:
                    line = {"unit": number, "wall": wall, **describe_wall(unit.square(wall))}
                    file.write(json.dumps(line) + "\n")
                    file.flush()


def count(path: Path) -> None:
    lines = read_lines(path)
    failed = [line for line in lines if "failure" in line]
    offsets = np.array([line["offset_error_deg"] for line in lines if "offset_error_deg" in line])
    walls = [line for line in lines if "wall" in line]
    final = np.array([line["final_deg"] for line in walls])
    touches = np.array([line["touches"] for line in walls])
    square = np.array([line["square"] for line in walls])
    forces = np.array([line["max_force_n"] for line in walls])
    own = np.sqrt(2.0) * ROBOT_DEG
    rows = {
        "units": len(offsets),
        "units that could not be opened": len(failed),
        "walls": len(walls),
        "tool's offset, rms / 90 % / greatest, deg": f"{rms(offsets):.3f} / {np.quantile(offsets, 0.9):.3f} / "
        f"{offsets.max():.3f}",
        "square": f"{square.mean():.1%}",
        "final angle, 50 / 90 / 99 % / greatest, deg": " / ".join(
            f"{each:.3f}" for each in (*np.quantile(final[square], [0.5, 0.9, 0.99]), final[square].max())
        ),
        "of all walls at most 0.3 deg": f"{np.mean((final <= 0.3) & square):.1%}",
        "final angle, rmse, deg": f"{rms(final[square]):.3f}",
        "above the robot's own (squares), deg": f"{np.sqrt(max(np.mean(final[square] ** 2) - own**2, 0.0)):.3f}",
        "touches, median / 99 % / most": f"{np.median(touches):g} / {np.quantile(touches, 0.99):g} / {touches.max()}",
        "force, greatest, N": f"{forces.max():.3f}",
        "the interval of what is left holds the truth": f"{np.mean([x['held'] for x in walls if x['square']]):.1%}",
        "endings": {line["outcome"]: sum(each["outcome"] == line["outcome"] for each in walls) for line in walls},
    }
    for name, value in rows.items():
        print(f"{name}: {value}")


def tabulate(path: Path) -> None:
    """Walls as a table beside the file."""
    names = ["unit", "wall", "tilt_deg", "friction", "touches", "images", "final_deg", "residual_deg"]
    names += ["residual_half_width_deg", "max_force_n", "outcome"]
    with path.with_suffix(".csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        for line in (line for line in read_lines(path) if "wall" in line):
            cells = (line[name] for name in names)
            writer.writerow([round(cell, 4) if isinstance(cell, float) else cell for cell in cells])


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("twin", type=Path)
    reader.add_argument("out", type=Path)
    reader.add_argument("--calibration-presses", type=int, default=5)
    reader.add_argument("--units", type=int, default=20)
    reader.add_argument("--walls", type=int, default=50)
    reader.add_argument("--solved", action="store_true")
    reader.add_argument("--count", action="store_true")
    chosen = reader.parse_args()
    if not chosen.count:
        play(chosen)
    count(chosen.out)
    tabulate(chosen.out)


if __name__ == "__main__":
    main()
