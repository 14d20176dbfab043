"""Measure the cost of each command, and write it into the table that `--help` reads.

    python benchmarks/command_costs.py [VERB ...]

Runs the command of each row of `src/palpate/cli/costs.csv`, or of the named verbs, in one empty folder, in the order
of the table: later commands read the results of earlier ones. Writes the CPU-seconds of the command and its worker
processes. Compiled kernels are in the cache; a first run after an installation takes 20 CPU-seconds more.
"""

import csv
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "src" / "palpate" / "cli" / "costs.csv"


def measure(words: list[str], folder: str) -> float:
    """CPU-seconds of a command and its worker processes."""
    before = getrusage(RUSAGE_CHILDREN)
    call = [sys.executable, "-m", "palpate", *words]
    done = subprocess.run(call, cwd=folder, stdout=subprocess.DEVNULL, check=False)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{shlex.join(words)} ends with exit code {done.returncode}.")
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(verbs: list[str]) -> None:
    """Measure the commands and rewrite the table."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "examples").symlink_to(ROOT / "examples")
        for row in rows:
            if not verbs or row["verb"] in verbs:
                seconds = measure(shlex.split(row["command"])[1:], folder)
                row["cpu_s"] = f"{float(f'{seconds:.2g}'):g}"
                print(f"{row['cpu_s']:>6} CPU-s  {row['command']}", flush=True)
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main(sys.argv[1:])
