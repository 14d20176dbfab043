"""Compare a wheel with the source: names by a table of renames, and the numbers of every command.

    python tests/inventory/compare.py WHEEL FOLDER [NAME …]

The wheel is unpacked to a folder of its own and runs with the libraries of this Python. Each command of
`commands.py`, or only those that are named, runs with the wheel and with the source; results lie in FOLDER/old and
FOLDER/new, and a command whose output is there is not run again. Files of the old version are then opened by the new
one. Prints a row for each difference and ends with 1 if there is one.
"""

import csv
import json
import math
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))
from inventory.commands import COMMANDS, PASSING

ROOT = Path(__file__).parents[2]
RENAMES = Path(__file__).with_name("renames.csv")
OLD_FILES = {
    "grid": "grid show {old}/small --json",
    "estimator": "live --source {data}/recording --model {old}/model.onnx --markers 61 --count 3 --json",
    "twin": "live --source {data}/recording --model {old}/small/twins/H20_T2.h5 --markers 61 --count 3 --json",
    "unit": "live --source {data}/recording --model {old}/small/twins/H20_T2.h5 --unit {old}/unit.json "
    "--markers 61 --count 3 --json",
    "recorded model": "live --source {data}/recording --model {old}/learnt/model.h5 --count 3 --json",
    "study": "status {data}/small.yaml --out {old}/small --json",
}
"""Files of the old version → how the new one opens them. It may refuse one if the message names a command."""


def renames(kind: str) -> dict[str, str]:
    """New name of each old one of a kind; empty for what has gone, with the reason in the table."""
    with RENAMES.open(newline="") as file:
        return {row["old"]: row["new"] for row in csv.DictReader(file) if row["kind"] == kind}


def compare_names(old: dict[str, list[str]], new: dict[str, list[str]]) -> Iterator[str]:
    """Names that have no place in the new inventory."""
    packages = renames("subpackage")
    for kind, names in old.items():
        table, verbs = renames(kind), renames("verb")
        for name in names:
            moved = table.get(name, name)
            if kind == "name" and moved:
                package, _, attribute = moved.rpartition(".")
                moved = f"{packages.get(package, package)}.{attribute}"
            if kind == "flag" and moved:
                verb, _, flag = moved.rpartition(" ")
                moved = f"{verbs.get(verb, verb)} {flag}"
            if moved and moved not in new.get(kind, ()):
                yield f"{kind}: {name} is missing" + (f" ({moved})" if moved != name else "")


def compare_values(old: Any, new: Any, place: str = "") -> Iterator[str]:
    """Values of two JSON documents that differ; keys are renamed by the table."""
    if isinstance(old, list) and isinstance(new, dict) and "rows" in new:  # beside the inputs of the command
        new = new["rows"]
    if isinstance(old, dict) and isinstance(new, dict):
        table = renames("key")
        for key, value in old.items():
            moved = table.get(key, key)
            moved = key if moved and moved not in new and key in new else moved  # renamed in other files only
            if key in PASSING or not moved:
                continue
            if moved not in new:
                yield f"{place}.{key} is missing"
            else:
                yield from compare_values(value, new[moved], f"{place}.{key}")
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for number, (one, other) in enumerate(zip(old, new, strict=True)):
            yield from compare_values(one, other, f"{place}[{number}]")
    elif isinstance(old, float) and isinstance(new, int | float) and math.isclose(old, new, rel_tol=1e-12):
        return
    elif isinstance(old, str) and isinstance(new, str):
        return  # sentences are compared by nobody; names are keys or numbers
    elif old != new:
        yield f"{place}: {json.dumps(old)[:60]} is now {json.dumps(new)[:60]}"


def data(folder: Path) -> Path:
    """Folder of the example data; for the old version a copy whose study has the old keys."""
    new = ROOT / "examples" / "data"
    if folder.name == "new":
        return new
    old = folder.parent / "data"
    if not old.exists():
        shutil.copytree(new, old)
        study = (old / "small.yaml").read_text()
        for one, other in renames("yaml").items():
            study = re.sub(rf"\b{other}:", f"{one}:", study)
        (old / "small.yaml").write_text(study)
    return old


def run(source: Path, words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run `palpate` of a source folder."""
    one = dict.fromkeys(("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    words = words.format(data=data(folder), old=folder.parent / "old")
    return subprocess.run(
        [sys.executable, "-m", "palpate", *words.split()],
        cwd=folder,
        env={**os.environ, **one, "PYTHONPATH": str(source)},
        capture_output=True,
        text=True,
        check=False,
    )


def output(source: Path, name: str, folder: Path) -> Any:
    """JSON of a command; its exit code and error if it printed none."""
    kept = folder / f"{name.replace(' ', '_').replace(',', '')}.json"
    if not kept.exists():
        done = run(source, new_words(name) if folder.name == "new" else COMMANDS[name], folder)
        try:
            found = json.loads(done.stdout or "{}")
        except ValueError:
            found = {"text": done.stdout}
        kept.write_text(json.dumps({"exit": done.returncode, "error": done.stderr[-500:], "output": found}))
    return json.loads(kept.read_text())


def new_words(name: str) -> str:
    """Words of a command with verbs and flags as they are now."""
    verb = name.partition(",")[0]
    words = COMMANDS[name].removeprefix(verb).split()
    flags = renames("flag")
    moved = [
        part
        for word in words
        for part in (flags.get(f"{verb} {word}", word).split()[-1:] if word.startswith("--") else [word])
    ]
    return " ".join([renames("verb").get(verb, verb), *moved])


def main(wheel: Path, folder: Path, names: list[str]) -> int:
    """Compare; return the exit code."""
    sources = {"old": folder / "wheel", "new": ROOT / "src"}
    if not sources["old"].exists():
        zipfile.ZipFile(wheel).extractall(sources["old"])
    inventories = {}
    for which, source in sources.items():
        (folder / which).mkdir(parents=True, exist_ok=True)
        inventories[which] = collect(source)
    differences = list(compare_names(inventories["old"], inventories["new"]))
    for name in names or COMMANDS:
        old, new = (output(sources[which], name, folder / which) for which in ("old", "new"))
        found = [f"{name}: {row}" for row in compare_values(old, new)]
        if old["exit"] not in (0, 1) or "palpate failed" in old["error"]:  # both may fail alike
            found.append(f"{name}: the old command fails: {old['error']}")
        if old["exit"] != new["exit"]:
            found.append(f"{name}: {new['error']}")
        print(f"{name}: {len(found) or 'no'} differences", file=sys.stderr, flush=True)
        differences += found
    differences += compare_names(*({"file": files(folder / which)} for which in sources)) if not names else ()
    for kind, words in OLD_FILES.items() if not names else ():
        if kind == "study":  # status may repair a result folder
            shutil.copytree(folder / "old" / "small", folder / "copy", dirs_exist_ok=True)
        done = run(sources["new"], words, folder / "new")
        if done.returncode not in (0, 1) and "palpate " not in done.stderr:
            differences.append(f"file of 0.2.0, {kind}: {done.stderr[-300:]}")
    print("\n".join(differences) or "no differences")
    return 1 if differences else 0


def files(folder: Path) -> list[str]:
    """Names of the files that commands wrote, each kind of stored artefact once."""
    found = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    return sorted({re.sub(r"\b[0-9a-f]{2}/[0-9a-f]{32}|-[0-9]{8}-[0-9]+", "*", name) for name in found})


def collect(source: Path) -> dict[str, list[str]]:
    """Inventory of the package in a source folder."""
    words = [sys.executable, str(Path(__file__).with_name("collect.py")), str(ROOT)]
    done = subprocess.run(words, env={**os.environ, "PYTHONPATH": str(source)}, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    found: dict[str, list[str]] = json.loads(done.stdout)
    return found


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), sys.argv[3:]))
