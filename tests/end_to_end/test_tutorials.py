"""The tutorials and the README run as written, in a copy of what a fresh clone contains.

A fenced block of these pages has one of these languages:

* `bash`: commands, run by the shell in the order of the page and in one folder. Each must end with exit code 0.
  Lines of `pip install` are not run; the extras that they name must exist and be installed, else the test is skipped.
* `output`: lines that the block before prints, in this order; `...` stands for lines that are left out. A terminal
  shows fewer columns than a file, so the end of a line may be missing. A number may differ by one unit of its last
  digit.
* `yaml` with the first line `# NAME`: a file that the reader writes.
* `text`: not run. The sentence before gives the reason: a command without end, or its cost.
* `python`: run by `test_readme.py`.

The artefacts of `examples/data/small.yaml`, which four pages and tests need, are computed once, by its command line.
So is a command that two pages give in the same words and that reads no file but those of the clone: the second page
gets its output and its files.

Directives of MyST have braces. Each file that a page names in back ticks exists after its commands.
"""

import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pytest

from needs import EXTRAS, needs
from presses import copy_artefacts, stored_folder

ROOT = Path(__file__).parents[2]
PAGES = [*sorted((ROOT / "docs" / "tutorials").glob("*.md")), ROOT / "README.md"]
CLONE = ("README.md", "examples", "studies", "plugins", "docs/results", "src/palpate/optimise/presets")
"""Paths of a clone that the commands of the pages read."""
FILE = re.compile(r"`([\w./-]+\.(?:csv|dxf|h5|jsonl?|md|onnx|pdf|png|sqlite|svg|xml|yaml))`")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")


SECONDS = {"README": 45, "best_design": 50, "first_dome": 50}
"""Page → CPU-seconds of its commands, if they are many."""


class Block(NamedTuple):
    """Fenced block of a page: language, lines, and number of its first line."""

    language: str
    lines: list[str]
    number: int


def read_blocks(page: Path) -> list[Block]:
    """Read the fenced blocks of a page."""
    blocks: list[Block] = []
    fence: str | None = None
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        mark = re.fullmatch(r"(`{3,})(\S*)(?: .*)?", line)
        if fence is None and mark is not None:
            fence = mark[1]
            blocks.append(Block(mark[2], [], number + 1))
        elif fence is not None and line == fence:
            fence = None
        elif fence is not None:
            blocks[-1].lines.append(line)
    assert fence is None, f"{page.name}: the block at line {blocks[-1].number} has no end"
    return blocks


def find_prose(page: Path) -> str:
    """Return the page without its fenced blocks."""
    return re.sub(r"^(`{3,}).*?^\1$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def find_installed(blocks: list[Block]) -> list[str]:
    """Return the extras that the page installs."""
    lines = [line for block in blocks if block.language == "bash" for line in block.lines]
    groups = re.findall(r"pip install .*?\[([\w,]+)\]", "\n".join(lines))
    return [name for group in groups for name in group.split(",")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_block_is_run_written_compared_or_marked_as_text(page: Path) -> None:
    wrong = [
        f"line {block.number}: {block.language or 'no language'}"
        for block in read_blocks(page)
        if not (
            block.language in ("bash", "output", "python", "text")
            or re.fullmatch(r"\{[\w-]+\}", block.language)
            or (block.language == "yaml" and re.match(r"# \S+\.yaml$", block.lines[0]))
        )
    ]
    assert wrong == []
    assert re.findall(r"^ {4,}palpate .*|^ +`{3}.*", find_prose(page), re.M) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_extra_that_a_page_installs_exists(page: Path) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(find_installed(read_blocks(page))) <= set(project["optional-dependencies"])


def copy_clone(folder: Path) -> None:
    """Copy the files that the commands read."""
    for name in CLONE:
        source, target = ROOT / name, folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(source, target) if source.is_dir() else shutil.copy2(source, target)


@cache
def find_shared() -> tuple[str, ...]:
    """Words of the commands, without paths of results and pipes, that several pages give."""
    given: Counter[str] = Counter()
    for page in PAGES:
        lines = [line for block in read_blocks(page) if block.language == "bash" for line in block.lines]
        commands = [shlex.split(line, comments=True) for line in "\n".join(lines).replace("\\\n", " ").splitlines()]
        given.update({" ".join(words) for words in commands if words and is_alone(words)})
    return tuple(words.removeprefix("palpate ") for words, pages in given.items() if pages > 1)


def is_alone(words: list[str]) -> bool:
    """Whether a command needs nothing but the clone: its paths are of examples, or follow an option of output."""
    paths = [word for before, word in pairwise(words) if "/" in word and before not in ("-o", "--out")]
    plain = not set("".join(words)) & set("|<>;&*$")
    return words[0] == "palpate" and plain and all(path.startswith("examples/") for path in paths)


def run_shared(words: str) -> Path:
    """Folder with the output of a command in a clone, and the files that it wrote there; run once for all pages."""

    def run(made: Path) -> None:
        folder, files = made / "clone", made / "files"
        prepare_clone(folder)
        before = {path for path in folder.rglob("*") if path.is_file()}
        environment = make_environment(made / "bin", shared=())
        (made / "output").write_text(run_block(Block("bash", [f"palpate {words}"], 0), folder, environment))
        files.mkdir()
        for path in {path for path in folder.rglob("*") if path.is_file()} - before:
            (files / path.relative_to(folder)).parent.mkdir(parents=True, exist_ok=True)
            path.rename(files / path.relative_to(folder))
        shutil.rmtree(folder)

    data = [path.read_bytes() for path in sorted((ROOT / "examples" / "data").rglob("*")) if path.is_file()]
    return stored_folder("command", [words, hashlib.sha256(b"\0".join(data)).hexdigest()], run)


def prepare_clone(folder: Path) -> None:
    """Copy the files that the commands read, and the artefacts of the small study."""
    copy_clone(folder)
    copy_artefacts(folder / "examples" / "data" / "small.yaml", folder / "results" / "small")


def make_environment(folder: Path, shared: Sequence[str]) -> dict[str, str]:
    """Return an environment in which `palpate` is this source, and shared commands give what they gave before."""
    command = folder / "palpate"
    command.parent.mkdir()
    cases = "".join(
        f"{shlex.quote(words)}) cp -R {kept}/files/. . && exec cat {kept}/output ;;\n"
        for words in shared
        for kept in [shlex.quote(str(run_shared(words)))]
    )
    command.write_text(f'#!/bin/sh\ncase "$*" in\n{cases}*) exec "{sys.executable}" -m palpate "$@" ;;\nesac\n')
    command.chmod(0o755)
    sources = [ROOT / "src", *sorted((ROOT / "plugins").iterdir())]
    path = os.pathsep.join(map(str, [*sources, os.environ.get("PYTHONPATH", "")])).rstrip(os.pathsep)
    return {**os.environ, "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": path}


def run_block(block: Block, folder: Path, environment: dict[str, str]) -> str:
    """Run the commands of a block, and return their output."""
    script = "\n".join(line for line in block.lines if "pip install" not in line)
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", script],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=1800,
    )
    assert done.returncode == 0, f"{script}\n{done.stdout[-3000:]}"
    return done.stdout


def is_like(shown: str, printed: str) -> bool:
    """Whether a line has the first words of another, and numbers within one unit of their last digit."""
    words, found = shown.split(), printed.split()[: len(shown.split())]
    if [NUMBER.sub("0", word) for word in words] != [NUMBER.sub("0", word) for word in found]:
        return False
    pairs = zip(NUMBER.findall(" ".join(words)), NUMBER.findall(" ".join(found)), strict=True)
    return all(abs(float(a) - float(b)) <= 1.01 * 10.0 ** -len(a.partition(".")[2]) for a, b in pairs)


def find_differences(shown: list[str], output: str) -> list[str]:
    """Return the shown lines that the output does not contain, in its order."""
    printed = iter([line for line in output.splitlines() if line.strip()])
    wanted = [line for line in shown if line.strip() and line.strip() != "..."]
    return [line for line in wanted if not any(is_like(line, each) for each in printed)][:1]


@pytest.mark.parametrize(
    "page", [pytest.param(page, id=page.stem, marks=pytest.mark.slow(SECONDS.get(page.stem, 20))) for page in PAGES]
)
def test_a_page_runs_as_written(page: Path, tmp_path: Path) -> None:
    blocks, folder = read_blocks(page), tmp_path / "clone"
    for name in find_installed(blocks):
        for module in EXTRAS.get(name, ()):
            needs(module)
    prepare_clone(folder)
    text = "\n".join(line for block in blocks if block.language == "bash" for line in block.lines)
    environment = make_environment(tmp_path / "bin", [words for words in find_shared() if f"palpate {words}" in text])
    output = ""
    for block in blocks:
        if block.language == "bash":
            output = run_block(block, folder, environment)
        elif block.language == "yaml":
            (folder / block.lines[0].removeprefix("# ")).write_text("\n".join(block.lines) + "\n")
        elif block.language == "output":
            assert (block.number, find_differences(block.lines, output)) == (block.number, []), output[-3000:]
    written = {str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()}
    named = set(FILE.findall(find_prose(page)))
    assert sorted(name for name in named if not any(f"/{file}".endswith(f"/{name}") for file in written)) == []


def test_commands_of_two_pages_are_run_once_and_those_that_read_results_on_each_page() -> None:
    shared = find_shared()
    assert "design stability --height 20 --thickness 2" in shared
    assert "recording train examples/data/recording --out trained --estimators fast" in shared
    assert is_alone(["palpate", "design", "make", "-o", "out/pack"])
    for words in ("palpate study show results/small", "palpate press | head", "cd examples", "palpate fit a/*.csv"):
        assert not is_alone(words.split())


def test_a_number_may_differ_by_one_unit_of_its_last_digit() -> None:
    assert is_like("a  0.58 N", "a 0.57  N")
    assert not is_like("a 0.58 N", "a 0.56 N")
    assert not is_like("a 0.58 N", "b 0.58 N")
    assert find_differences(["a 1", "...", "c"], "a 1\nb\n\nc\n") == []
    assert find_differences(["c", "a 1"], "a 1\nb\nc\n") == ["a 1"]
