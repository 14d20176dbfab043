"""Plant faults in copies of the source, one at a time, and run the fast tests: does the suite notice?

    python tests/planted/plant_faults.py FOLDER [--seed 1] [--each 10] [--area NAME] [--coverage FILE]

Places are drawn by a seed in five areas of the source; each gets one fault that a programmer could make: a sign, a
factor, swapped arguments, an index off by one, a dropped term, a mask of the wrong half, a missing check. A copy of
the checkout with that fault runs the tests of the subpackage first, then the reference cases, then all fast tests,
until one fails. With the coverage of a run (`pytest --cov=palpate --cov-context=test`), only the tests that execute
the changed line run in place of all. FOLDER/faults.json has an entry for each fault: an interrupted run resumes.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import json
import os
import random
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCE = Path("src", "palpate")
AREAS = {
    "mechanics and fea": ("mechanics", "fea"),
    "surrogate and calibration": ("twin", "built", "surrogate", "calibration"),
    "detection and assignment": ("markers", "vision"),
    "learning": ("learn", "recording", "dataset", "datasets"),
    "store and command line": ("core", "cli", "study"),
}
"""Area → its subpackages, under their names before and after the restructuring."""
LIMIT_S = 1800.0
"""Time after which a run of the tests counts as a failure: the fault hangs it."""


@dataclass(frozen=True)
class Fault:
    """One change of a source file."""

    area: str
    path: str
    line: int
    kind: str
    text: str
    """The whole file with the fault."""

    @property
    def difference(self) -> str:
        """Changed lines."""
        old = (ROOT / self.path).read_text().splitlines()
        lines = difflib.unified_diff(old, self.text.splitlines(), lineterm="", n=0)
        return "\n".join(line for line in lines if line[:1] in "+-" and line[:3] not in ("+++", "---"))


def sign(node: ast.AST) -> Iterator[ast.AST]:
    """a + b → a - b, and the reverse."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub) and not is_text(node):
        yield ast.BinOp(node.left, ast.Sub() if isinstance(node.op, ast.Add) else ast.Add(), node.right)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
        yield node.operand


def factor(node: ast.AST) -> Iterator[ast.AST]:
    """A number twice as large."""
    if isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value not in (0.0,):
        yield ast.Constant(2.0 * node.value)


def swapped(node: ast.AST) -> Iterator[ast.AST]:
    """f(a, b) → f(b, a)."""
    if isinstance(node, ast.Call) and len(node.args) >= 2 and ast.unparse(node.func) not in UNORDERED:
        first, second, *others = node.args
        if ast.unparse(first) != ast.unparse(second) and not isinstance(first, ast.Starred | ast.Constant):
            yield ast.Call(node.func, [second, first, *others], node.keywords)


def off_by_one(node: ast.AST) -> Iterator[ast.AST]:
    """An index, a bound or a count that is larger by one; < for <=."""
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant) and type(node.slice.value) is int:
        yield ast.Subscript(node.value, ast.Constant(node.slice.value + 1), node.ctx)
    if isinstance(node, ast.Slice) and isinstance(node.lower, ast.Constant) and type(node.lower.value) is int:
        yield ast.Slice(ast.Constant(node.lower.value + 1), node.upper, node.step)
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in TURNED:
        yield ast.Compare(node.left, [TURNED[type(node.ops[0])]()], node.comparators)


UNORDERED = ("max", "min", "np.maximum", "np.minimum", "isinstance")
TURNED: dict[type[ast.cmpop], type[ast.cmpop]] = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}


def dropped(node: ast.AST) -> Iterator[ast.AST]:
    """a + b → a; a * b → a."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub | ast.Mult) and not is_text(node):
        yield node.left


def leak(node: ast.AST) -> Iterator[ast.AST]:
    """~mask → mask: the other half of a set."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Invert):
        yield node.operand


def unchecked(node: ast.AST) -> Iterator[ast.AST]:
    """A check that never fires."""
    if isinstance(node, ast.If) and any(isinstance(one, ast.Raise) for one in node.body):
        yield ast.If(ast.Constant(False), node.body, node.orelse)


KINDS: dict[str, Callable[[ast.AST], Iterator[ast.AST]]] = {
    "sign": sign,
    "factor": factor,
    "swapped arguments": swapped,
    "off by one": off_by_one,
    "dropped term": dropped,
    "leak": leak,
    "missing check": unchecked,
}


def is_text(node: ast.BinOp) -> bool:
    return any(isinstance(one, ast.JoinedStr) or is_string(one) for one in ast.walk(node))


def is_string(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def places(path: Path) -> Iterator[tuple[ast.AST, str, ast.AST]]:
    """Nodes of a file with a kind of fault and the node that replaces it; only inside functions."""
    tree = ast.parse(path.read_text())
    functions = [one for one in ast.walk(tree) if isinstance(one, ast.FunctionDef | ast.AsyncFunctionDef)]
    seen: set[int] = set()
    for function in functions:
        for statement in function.body:
            if isinstance(statement, ast.Expr) and is_string(statement.value):
                continue
            for node in ast.walk(statement):
                if id(node) in seen or isinstance(node, ast.Raise | ast.JoinedStr):
                    continue
                seen.add(id(node))
                for kind, change in KINDS.items():
                    for other in change(node):
                        yield node, kind, other


def draw(area: str, count: int, seed: int) -> list[Fault]:
    """Faults of an area: kinds in turn, places at random, no two in one function's line."""
    rng = random.Random(f"{seed} {area}")
    by_kind: dict[str, list[tuple[Path, ast.AST, ast.AST]]] = {kind: [] for kind in KINDS}
    for subpackage in AREAS[area]:
        for path in sorted((ROOT / SOURCE / subpackage).rglob("*.py")):
            for node, kind, other in places(path):
                by_kind[kind].append((path, node, other))
    kinds = [kind for kind in KINDS if by_kind[kind]]
    faults: list[Fault] = []
    while len(faults) < count:
        kind = kinds[len(faults) % len(kinds)]
        path, node, other = rng.choice(by_kind[kind])
        text = replaced(path.read_text(), node, other)
        if text is not None:
            faults.append(Fault(area, str(path.relative_to(ROOT)), node.lineno, kind, text))  # type: ignore[attr-defined]
    return faults


def replaced(text: str, node: ast.AST, other: ast.AST) -> str | None:
    """Text of a file with a node replaced; `None` if the result is no program or the same one."""
    lines = text.splitlines(keepends=True)
    start = sum(len(line) for line in lines[: node.lineno - 1]) + offset(lines[node.lineno - 1], node.col_offset)  # type: ignore[attr-defined]
    end = sum(len(line) for line in lines[: node.end_lineno - 1]) + offset(  # type: ignore[attr-defined]
        lines[node.end_lineno - 1],  # type: ignore[attr-defined]
        node.end_col_offset,  # type: ignore[attr-defined]
    )
    if isinstance(node, ast.If):
        test = node.test
        start = sum(len(line) for line in lines[: test.lineno - 1]) + offset(lines[test.lineno - 1], test.col_offset)
        end = sum(len(line) for line in lines[: (test.end_lineno or 0) - 1]) + offset(
            lines[(test.end_lineno or 0) - 1], test.end_col_offset or 0
        )
        written = "False"
    else:
        written = ast.unparse(ast.fix_missing_locations(other))
        if isinstance(other, ast.BinOp | ast.Compare | ast.UnaryOp) or isinstance(node, ast.UnaryOp):
            written = f"({written})"
    changed = text[:start] + written + text[end:]
    try:
        same = ast.dump(ast.parse(changed)) == ast.dump(ast.parse(text))
    except SyntaxError:
        return None
    return None if same else changed


def offset(line: str, bytes_before: int) -> int:
    """Characters before a place that the syntax tree gives in bytes."""
    return len(line.encode()[:bytes_before].decode())


def stages(fault: Fault, coverage: Path | None) -> list[list[str]]:
    """Arguments of pytest, the likeliest to notice first; all fast tests last, or those that execute the line."""
    subpackage = Path(fault.path).parts[2]
    own = ROOT / "tests" / "unit" / subpackage
    chosen = [["-n", "0", f"tests/unit/{subpackage}"]] if own.exists() else []
    if coverage is None:
        return [*chosen, ["-n", "0", "tests/behaviour"], ["-n", "2"]]
    names = executed_by(coverage, fault)
    if not names:  # compiled by numba, or executed in a process without coverage
        return [*chosen, ["-n", "0", "tests/behaviour"]]
    in_own = [name for name in names if name.startswith(f"tests/unit/{subpackage}/")]
    others = [name for name in names if name not in in_own]
    return [["-n", "0", *part] for part in (in_own, others) if part]


def executed_by(coverage: Path, fault: Fault) -> list[str]:
    """Tests that execute the line of a fault, by a coverage file with contexts."""
    from coverage import CoverageData

    data = CoverageData(str(coverage))
    data.read()
    measured = [path for path in data.measured_files() if path.endswith(fault.path)]
    contexts = {name for path in measured for name in data.contexts_by_lineno(path).get(fault.line, ())}
    return sorted({name.rpartition("|")[0] for name in contexts if name.startswith("tests/")})


def try_fault(fault: Fault, folder: Path, coverage: Path | None) -> dict[str, object]:
    """Run the tests on a copy with the fault; tell which test failed first."""
    copy = folder / "copy"
    if copy.exists():
        shutil.rmtree(copy)
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split(
        "\n"
    )
    for name in filter(None, listed):
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, copy / name)
    (copy / fault.path).write_text(fault.text)
    environment = {**os.environ, "PYTHONPATH": str(copy / "src"), "NUMBA_CACHE_DIR": str(folder / "kernels")}
    environment |= dict.fromkeys(("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    start = time.monotonic()
    for words in stages(fault, coverage):
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "--tb=no", "-p", "no:cacheprovider", *words]
        try:
            done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            return result(fault, "the tests did not end", start)
        said = f"{done.stdout}\n{done.stderr}"
        if re.search(r"^ERROR: (file or directory )?not found", said, re.MULTILINE):  # no test has run
            raise SystemExit(f"A test of the coverage file does not exist: {said[-300:]}")
        failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
        if done.returncode not in (0, 5):
            refuse_failing_control(failed, copy, fault, environment)
            return result(fault, failed[0][:150] if failed else done.stdout[-300:], start)
    return result(fault, "", start)


def refuse_failing_control(failed: list[str], copy: Path, fault: Fault, environment: dict[str, str]) -> None:
    """End if the test that notices a fault fails without the fault, too: it would notice everything."""
    shutil.copy2(ROOT / fault.path, copy / fault.path)
    names = [line.split(maxsplit=1)[1].partition(" - ")[0] for line in failed]
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *names]
    if names and subprocess.run(command, cwd=copy, env=environment, capture_output=True).returncode != 0:
        raise SystemExit(f"{names[0]} fails without a fault.")


def result(fault: Fault, caught_by: str, start: float) -> dict[str, object]:
    """Entry of `faults.json`."""
    return {
        "area": fault.area,
        "place": f"{fault.path}:{fault.line}",
        "kind": fault.kind,
        "difference": fault.difference,
        "caught_by": caught_by,
        "seconds": round(time.monotonic() - start),
    }


def main() -> int:
    """Plant every fault that has no entry yet; print the faults that were not caught."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--each", type=int, default=10)
    parser.add_argument("--area", choices=AREAS)
    parser.add_argument("--coverage", type=Path, help="coverage file with contexts: run the tests of the line only")
    parser.add_argument("--list", action="store_true", help="print the faults and run nothing")
    chosen = parser.parse_args()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    kept = chosen.folder / "faults.json"
    entries: dict[str, dict[str, object]] = json.loads(kept.read_text()) if kept.exists() else {}
    for area in [chosen.area] if chosen.area else AREAS:
        for number, fault in enumerate(draw(area, chosen.each, chosen.seed)):
            name = f"{chosen.seed} {area} {number}"
            if chosen.list:
                print(f"{name}: {fault.kind}, {fault.path}:{fault.line}\n{fault.difference}\n")
                continue
            if name not in entries or entries[name]["difference"] != fault.difference:
                entries[name] = try_fault(fault, chosen.folder, chosen.coverage)
                kept.write_text(json.dumps(entries, indent=1))
            print(f"{name}: {entries[name]['caught_by'] or 'NOT CAUGHT'}", flush=True)
    missed = {name: entry for name, entry in entries.items() if not entry["caught_by"]}
    for name, entry in missed.items():
        print(f"\n{name}, {entry['kind']}, {entry['place']}\n{entry['difference']}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
