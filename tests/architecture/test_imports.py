"""Imports point one way, go through front doors, and are fast."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from importlinter.application.use_cases import read_user_options
from importlinter.cli import lint_imports
from source_files import FILES, SOURCE, name, nodes

ROOT = Path(__file__).parents[2]
OWN_DOORS = tuple(
    f"palpate.core.{name}"
    for name in ("files", "named_arrays", "report", "run", "state", "store_lock", "tables", "units")
)
"""Modules that are imported by their own path: `palpate.core` has no room for their names."""
STAGES = {path.name for path in SOURCE.iterdir() if path.is_dir() and path.name != "__pycache__"}


def test_stages_import_in_one_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.syspath_prepend(str(ROOT / "src"))
    assert read_user_options(None).contracts_options
    assert lint_imports(no_cache=True) == 0


def test_other_stages_are_imported_through_their_public_names() -> None:
    inner = []
    for path in FILES:
        own = "cli" if path.name == "cli.py" else name(path).split("/")[0]  # commands of a plug-in
        for node in nodes(path):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("palpate."):
                parts = (node.module or "").split(".")
                if parts[1] in STAGES and parts[1] != own and len(parts) > 2 and node.module not in OWN_DOORS:
                    inner.append(f"{name(path)}: {node.module}")
    assert inner == []


def test_presses_are_interpolated_in_one_stage() -> None:
    """Splines above `palpate.fea` are in `palpate.surrogate`: of fields, of twins, and of modes along the skin."""
    splines = {
        name(path)
        for path in FILES
        for node in nodes(path)
        if isinstance(node, ast.ImportFrom)
        and node.module == "scipy.interpolate"
        and {item.name for item in node.names} != {"RBFInterpolator"}  # over measurements, not over presses
    }
    below = {"design", "deck", "fea", "verify"}  # shapes, and the work of a press along its own increments
    assert {file for file in splines if Path(file).parts[0] not in below} == {
        "surrogate/tensor_spline.py",
        "surrogate/tilt_runs.py",
        "surrogate/twin.py",
    }


def imports_of(path: Path) -> set[str]:
    """Modules of the package that a file imports anywhere in it, inside functions and for types alone as well."""
    found = set()
    for node in nodes(path):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("palpate"):
            found |= {f"{node.module}.{alias.name}" for alias in node.names} | {str(node.module)}
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


def test_no_import_leads_back_to_its_own_file_even_a_lazy_one() -> None:
    own = {path: f"palpate/{name(path)}" if path.is_relative_to(SOURCE) else name(path) for path in FILES}
    names = {place.removesuffix(".py").replace("/", "."): path for path, place in own.items()}
    doors = {name: name.removesuffix(".__init__") for name in names}
    known = {short: name for name, short in doors.items()}
    ahead = {
        name: {known[target] for target in imports_of(path) & set(known)} - {name} for name, path in names.items()
    }
    circles: list[list[str]] = []
    done: set[str] = set()

    def walk(name: str, trail: list[str]) -> None:
        if name in trail:
            circles.append([*trail[trail.index(name) :], name])
        elif name not in done:
            for target in sorted(ahead[name]):
                walk(target, [*trail, name])
            done.add(name)

    for start in sorted(ahead):
        walk(start, [])
    assert circles == []


def seconds_to_run(code: str) -> float:
    """CPU time, best of three runs in fresh interpreters, less that of an empty one."""

    def run(text: str) -> float:
        before = os.times()
        subprocess.run([sys.executable, "-c", text], check=True, cwd=ROOT / "src", capture_output=True)
        after = os.times()
        return after.children_user + after.children_system - before.children_user - before.children_system

    return min(run(code) for _ in range(3)) - min(run("pass") for _ in range(3))


@pytest.mark.parametrize("code", ["import palpate.core", "import palpate.design", "from palpate.cli import main"])
def test_the_front_of_the_house_opens_within_a_second(code: str) -> None:
    assert seconds_to_run(code) < 1.0


HELP_OF_EVERY_VERB = """
import contextlib, io, json, sys
from command_table import list_commands
from palpate.cli import main
heavy, found = {"torch", "numba", "scipy.linalg", "cv2", "h5py", "matplotlib", "build123d", "optuna"}, {}
for verb, _ in list_commands():
    with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
        main([*verb.split(), "--help"])
    found[verb] = sorted(heavy & set(sys.modules))
print(json.dumps(found))
"""


def test_the_help_of_every_verb_loads_no_heavy_libraries() -> None:
    path = os.pathsep.join([str(ROOT / "tests" / "unit" / "cli"), os.environ.get("PYTHONPATH", "")])
    code = [sys.executable, "-c", HELP_OF_EVERY_VERB]
    shown = subprocess.run(
        code, check=True, cwd=ROOT / "src", capture_output=True, text=True, env=os.environ | {"PYTHONPATH": path}
    )
    found = json.loads(shown.stdout)
    assert len(found) >= 38
    assert {verb: loaded for verb, loaded in found.items() if loaded} == {}


def test_reading_a_study_does_not_load_torch() -> None:
    code = "import sys, palpate.study; print('torch' in sys.modules)"
    shown = subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT / "src", capture_output=True, text=True)
    assert shown.stdout.strip() == "False"
