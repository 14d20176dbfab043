#!/usr/bin/env python3
"""Hold the CPU-seconds and the iterations of the cases in tests/speed against the last release.

    python .ci/speed.py             # compare with the runs of the last version; exit code 1 if slower
    python .ci/speed.py --append    # measure three times and add the runs to this version's

CPU-seconds differ from machine to machine, so a case is told by its ratio to a yardstick of known work, run before
and after every round of it (tests/speed/yardstick.py): mean over mean, which under other work was steadier than least
over least (docs/speed.md). That ratio differs too, by machine and by what else it does: so the last release is known
by several runs (docs/results/speed_runs.csv), and a case is refused that is slower than the slowest of them by more
than the limit. One that is too slow is measured again, twice at most, and the least ratio counts. Iterations and
unknowns are counts: one that falls by more than the limit is refused as well, for then the case has become another
one. On a processor that no run of the last release knows ratios are told, and only counts are refused.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

ROOT = Path(__file__).parents[1]
RUNS = ROOT / "docs" / "results" / "speed_runs.csv"
HISTORY = ROOT / "docs" / "results" / "speed.csv"
"""Every run of every version, and their medians by version and processor: what the page shows."""
LIMIT = 0.20
"""Share by which a case may be slower, or count more or less, than in any run of the last release."""
AGAIN, APPENDED = 2, 3
"""Times that a slow case is measured again, and that all are measured for a release."""


class SpeedError(Exception):
    """One sentence that says what is wrong and what to do."""


@dataclass(frozen=True)
class Row:
    """One case in one run of one version: ratio to the yardstick, what it counts, CPU-seconds and processor."""

    version: str
    case: str
    ratio: float
    iterations: int
    unknowns: int
    cpu_s: float
    processor: str


@dataclass(frozen=True)
class Finding:
    """What the comparison says of one case."""

    case: str
    text: str
    refused: bool
    slow: bool = False


def read_runs(path: Path = RUNS) -> list[Row]:
    """Rows of every run of every version, oldest first."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = [
                Row(
                    each["version"],
                    each["case"],
                    float(each["ratio"]),
                    int(each["iterations"]),
                    int(each["unknowns"]),
                    float(each["cpu_s"]),
                    each["processor"],
                )
                for each in csv.DictReader(file)
            ]
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise SpeedError(f"{path} cannot be read ({error!r}). Take the committed file again.") from None
    if not rows or not all(row.ratio > 0 and row.iterations > 0 and row.unknowns > 0 for row in rows):
        raise SpeedError(f"{path} has no row, or one that is not positive. Take the committed file again.")
    return rows


def last_release(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Rows of the last version's runs, by case."""
    rows = list(rows)
    cases: dict[str, list[Row]] = {}
    for row in rows:
        if row.version == rows[-1].version:
            cases.setdefault(row.case, []).append(row)
    return cases


def read_measured(path: Path) -> dict[str, Row]:
    """Rows from what pytest-benchmark has written, by case."""
    found, version, processor = {}, _version(), _processor()
    for each in json.loads(path.read_text(encoding="utf-8"))["benchmarks"]:
        extra = each["extra_info"]
        case = each["name"].removeprefix("test_").replace("[", "_").removesuffix("]")
        ratio = statistics.mean(extra["rounds"]) / statistics.mean(extra["yardsticks"])
        counts = extra["iterations"], extra["unknowns"]
        found[case] = Row(version, case, ratio, *counts, min(extra["rounds"]), processor)
    return found


def compare(last: Mapping[str, list[Row]], now: Mapping[str, Row], limit: float = LIMIT) -> list[Finding]:
    """Hold what was measured against the slowest run of the last release, case by case."""
    findings = []
    for case, runs in last.items():
        old, new = max(runs, key=lambda run: run.ratio), now.get(case)
        if new is None:
            findings.append(Finding(case, "was not measured: install the extras 'all' and 'test'", refused=True))
            continue
        slower = new.ratio / old.ratio - 1
        usual = new.ratio / statistics.median(run.ratio for run in runs) - 1
        text = f"ratio {new.ratio:.3g}, {usual:+.0%} against {old.version}, {slower:+.0%} against its slowest run"
        counts = {name: (getattr(old, name), getattr(new, name)) for name in ("iterations", "unknowns")}
        moved = [f"{name} {a} -> {b}" for name, (a, b) in counts.items() if abs(b / a - 1) > limit]
        known = new.processor in {run.processor for run in runs}
        slow = known and slower > limit
        text += ": SLOWER" if slow else "" if known else ", which was never measured on this processor"
        findings.append(Finding(case, "; ".join([text, *moved]), slow or bool(moved), slow))
    new_cases = [
        Finding(case, "is new: no release to compare with", refused=False) for case in now if case not in last
    ]
    return findings + new_cases


def keep_fastest(first: Mapping[str, Row], again: Mapping[str, Row]) -> dict[str, Row]:
    """Of two measurements of a case the one of least ratio."""
    return {case: min(row, again.get(case, row), key=lambda each: each.ratio) for case, row in first.items()}


def medians(rows: Iterable[Row]) -> list[Row]:
    """The median of the runs of each case, by version and processor, in the order in which they come."""
    alike: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        alike.setdefault((row.version, row.processor, row.case), []).append(row)
    return [
        replace(
            runs[0],
            ratio=statistics.median(run.ratio for run in runs),
            cpu_s=statistics.median(run.cpu_s for run in runs),
        )
        for runs in alike.values()
    ]


def write_rows(path: Path, rows: Iterable[Row]) -> None:
    """Write rows as a table."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [each.name for each in fields(Row)], lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow(asdict(row) | {"ratio": f"{row.ratio:.4g}", "cpu_s": f"{row.cpu_s:.3g}"})


def measure(cases: Iterable[str] = ()) -> dict[str, Row]:
    """Run the cases, or these alone, in one process on one thread."""
    wanted = set(cases)
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch) / "speed.json"
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-n",
            "0",
            "-m",
            "speed",
            "tests/speed/test_speed.py",
            f"--benchmark-json={out}",
        ]
        command += ["--benchmark-timer=time.process_time", "--benchmark-columns=min,median,max"]
        if wanted:  # names of pytest have brackets, which -k does not take
            command += ["-k", " or ".join(sorted({case.removeprefix("press_") for case in wanted}))]
        one = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
        if subprocess.run(command, cwd=ROOT, env=os.environ | one, check=False).returncode:
            raise SpeedError("A case of tests/speed failed: see above.")
        found = read_measured(out)
    return {case: row for case, row in found.items() if not wanted or case in wanted}


def _version() -> str:
    project: dict[str, str] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return project["version"]


def _processor(path: Path = Path("/proc/cpuinfo")) -> str:
    """Maker, family and model of the processor: its name alone is that of many on a virtual machine."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    told = dict(reversed([tuple(map(str.strip, line.split(":", 1))) for line in lines if ":" in line]))
    return " ".join(told.get(name, "?") for name in ("vendor_id", "cpu family", "model"))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--append", action="store_true", help="add three runs to this version's")
    given = parser.parse_args()
    rows = read_runs() if RUNS.exists() or not given.append else []
    if given.append:
        rows += [row for _ in range(APPENDED) for row in measure().values()]
        write_rows(RUNS, rows)
        write_rows(HISTORY, medians(rows))
        return 0
    last, now = last_release(rows), measure()
    for _ in range(AGAIN):
        slow = [finding.case for finding in compare(last, now) if finding.slow]
        if slow:
            print(f"measured again: {', '.join(slow)}")
            now = keep_fastest(now, measure(slow))
    findings = compare(last, now)
    for finding in findings:
        print(f"{'REFUSED' if finding.refused else 'ok':8}{finding.case}: {finding.text}")
    return int(any(finding.refused for finding in findings))


if __name__ == "__main__":
    try:
        sys.exit(main())
    except SpeedError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
