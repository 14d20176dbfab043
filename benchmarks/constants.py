"""Sensitivity of the tuned constants of one subpackage: quick unit tests that fail at half and at twice each value.

    python benchmarks/constants.py vision

It rewrites the rows of the subpackage in `docs/results/constants.csv`. For each constant, the quickest tests that
call a function of its file are run, `BUDGET_S` in all, each value in a process of its own; fewer than `LEAST_TESTS`
make no row. `half` and `double` are the numbers of failed tests, or `stopped` without an end; `tests` is that of
the tests. No failure does not mean that nothing changes. A value that is compiled, a default of an argument or part
of another constant has no row, because its attribute is not read again.
"""

import ast
import csv
import importlib
import os
import resource
import sys
from collections import Counter
from functools import partial
from pathlib import Path
from types import FrameType, ModuleType

import pytest

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "palpate"
TABLE = ROOT / "docs" / "results" / "constants.csv"
FIELDS = ["file", "constant", "value", "tests", "half", "double"]
LEAST_TESTS = 5
BUDGET_S, LONGEST_S, STOP_S = 1.0, 1.0, 20
"""Duration of all tests of a constant, and of a single one; CPU time after which a run is stopped, s."""
PLAIN = ast.Constant | ast.Tuple | ast.BinOp | ast.UnaryOp
Value = int | float | tuple["Value", ...]


class Sensitivity:
    """A session of pytest that runs its tests again for each changed constant."""

    def __init__(self, subpackage: str) -> None:
        self.subpackage = subpackage
        self.called: dict[str, set[str]] = {}
        self.durations: Counter[str] = Counter()
        self.failed: set[str] = set()
        self.rows: list[dict[str, str]] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a duration and a failure."""
        self.durations[report.nodeid] += report.duration
        if report.failed:
            self.failed.add(report.nodeid)

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run all tests once, then those of each constant at both values."""
        self.called, self.durations, self.failed = in_child(lambda: self.first_run(session))
        items = {item.nodeid: item for item in session.items}
        print(f"{len(items)} tests, {sum(self.durations.values()):.0f} s", flush=True)
        for path in sorted((SOURCE / self.subpackage).rglob("*.py")):
            tests = [items[name] for name in self.tests_of(path)]
            if len(tests) < LEAST_TESTS:
                continue
            for name, value in constants(path).items():
                self.measure(path, name, value, tests)
        return True

    def first_run(self, session: pytest.Session) -> tuple[object, ...]:
        """Files that each test calls, durations and failures."""
        for item in session.items:
            files: set[str] = set()
            sys.setprofile(partial(note, files))
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
            sys.setprofile(None)
            self.called[item.nodeid] = files
        return self.called, self.durations, self.failed

    def tests_of(self, path: Path) -> list[str]:
        """Quickest passing tests that call a file, up to the permitted time."""
        chosen, spent = [], 0.0
        for name in sorted(self.called, key=lambda one: self.durations[one]):
            if str(path) in self.called[name] and name not in self.failed and self.durations[name] <= LONGEST_S:
                spent += self.durations[name]
                if spent > BUDGET_S and chosen:
                    break
                chosen.append(name)
        return chosen

    def measure(self, path: Path, name: str, value: Value, tests: list[pytest.Item]) -> None:
        """Add a row."""
        row = {"file": path.relative_to(SOURCE).as_posix(), "constant": name, "value": str(value)}
        row["tests"] = str(len(tests))
        for column, factor in (("half", 0.5), ("double", 2.0)):
            changed = scaled(value, factor)
            failed = in_child(lambda changed=changed: self.run(path, name, changed, tests), STOP_S)
            row[column] = "stopped" if failed is None else str(len(failed))
        print(*row.values(), sep=", ", flush=True)
        self.rows.append(row)

    def run(self, path: Path, name: str, value: Value, tests: list[pytest.Item]) -> set[str]:
        """Tests that fail with a changed constant."""
        self.failed = set()
        patch(module_of(path), name, value)
        for item in tests:
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
        return self.failed


def note(files: set[str], frame: FrameType, event: str, _: object) -> None:
    """Note the file of a called function."""
    if event == "call":
        files.add(frame.f_code.co_filename)


def in_child(work, limit_s: int = 3600):  # type: ignore[no-untyped-def]
    """Value of a function in a copy of this process, through its representation; None if it is stopped."""
    reader, writer = os.pipe()
    if (child := os.fork()) == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s))
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        with os.fdopen(writer, "w") as out:
            out.write(repr(tuple(dict(one) if isinstance(one, Counter) else one for one in work())))
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as source:
        text = source.read()
    os.waitpid(child, 0)
    return eval(text, {"set": set}) if text else None


def patch(module: str, name: str, value: Value) -> None:
    """Set a constant in its module and in every module that imported it by name."""
    before = getattr(sys.modules[module], name)
    for other in list(sys.modules.values()):
        own = isinstance(other, ModuleType) and other.__name__.startswith("palpate")
        if own and vars(other).get(name) is before:
            setattr(other, name, value)


def scaled(value: Value, factor: float) -> Value:
    """A constant times a factor; whole numbers stay whole."""
    if isinstance(value, tuple):
        return tuple(scaled(one, factor) for one in value)
    return int(value * factor) if isinstance(value, int) else value * factor


def module_of(path: Path) -> str:
    """Name of the module of a file."""
    return ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)


def constants(path: Path) -> dict[str, Value]:
    """Numeric constants at module level whose attribute is read when it is used."""
    tree = ast.parse(path.read_text())
    assigned = [node for node in tree.body if isinstance(node, ast.Assign) and isinstance(node.value, PLAIN)]
    targets = [one for node in assigned for target in node.targets for one in ast.walk(target)]
    names = {one.id for one in targets if isinstance(one, ast.Name)}
    fixed: set[str] = set()
    for node in ast.walk(tree):
        fixed |= {one.id for part in frozen_parts(node) for one in ast.walk(part) if isinstance(one, ast.Name)}
    module = importlib.import_module(module_of(path))
    values = {name: getattr(module, name) for name in sorted(names - fixed) if name.strip("_").isupper()}
    return {name: value for name, value in values.items() if is_number(value)}


def frozen_parts(node: ast.AST) -> list[ast.AST]:
    """Parts of a statement that are evaluated once, or compiled."""
    if isinstance(node, ast.FunctionDef):
        parts: list[ast.AST] = [*node.args.defaults, *(one for one in node.args.kw_defaults if one)]
        compiled = any(isinstance(mark, ast.Name) and mark.id == "kernel" for mark in node.decorator_list)
        return [*parts, *node.decorator_list, *(node.body if compiled else [])]
    if isinstance(node, ast.ClassDef):
        return [one for one in node.body if isinstance(one, ast.AnnAssign | ast.Assign)]
    return [node.value] if isinstance(node, ast.Assign) and node.col_offset == 0 else []


def is_number(value: object) -> bool:
    """Numbers and tuples of numbers."""
    if isinstance(value, tuple):
        return bool(value) and all(is_number(one) for one in value)
    return isinstance(value, int | float) and not isinstance(value, bool)


def main(subpackage: str) -> None:
    """Rewrite the rows of a subpackage."""
    sensitivity = Sensitivity(subpackage)
    flags = ["-q", "-s", "-n0", "-p", "no:cacheprovider", "-m", "not slow and not speed"]
    pytest.main([*flags, str(ROOT / "tests" / "unit" / subpackage)], plugins=[sensitivity])
    rows = list(sensitivity.rows)
    if TABLE.exists():
        with TABLE.open(newline="", encoding="utf-8") as file:
            rows += [row for row in csv.DictReader(file) if not row["file"].startswith(subpackage + "/")]
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda row: (row["file"], row["constant"])))


if __name__ == "__main__":
    main(sys.argv[1])
