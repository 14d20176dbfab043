"""A wrong input at every door of every command ends at once: one sentence, its remedy, exit code 2, nothing left."""

import copy
import re
import shlex
import time
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

import pydantic
import pytest
from command_table import list_commands
from cyclopts import App, Argument
from cyclopts.argument import ArgumentCollection
from doors import ROWS, furnish

from needs import needs
from palpate.cli import main
from palpate.learn.member import ImageRidge
from results import leave_out_pictures

COMMANDS = dict(list_commands())
ASSEMBLED: dict[Any, ArgumentCollection] = {}
ADAPTER = cache(pydantic.TypeAdapter)
HEAVY = (
    ("mechanics.newton", "Problem", "solve"),
    ("study.run_study", "Run", "run"),
    ("viewer.guard", "Guard", "__init__"),
)
"""What computes or serves: module, class, method."""
SLOW = (
    "doctor",
    "design make",
    "design specimens",
    "calibration camera",
    "calibration identify",
    "simulation align",
)
"""Commands that take seconds where everything is right; their own tests call them."""
LONGEST_S = 10.0
"""Longest time of a refusal; most take a tenth of a second."""


def arguments_of(name: str) -> Iterator[tuple[str, Argument]]:
    for argument in COMMANDS[name].assemble_argument_collection():
        if argument.parse and not argument.children:
            yield argument.names[0] if argument.names else argument.field_info.name.upper(), argument


def kinds_of(argument: Argument) -> set[Any]:
    hint = argument.hint
    return {hint, *get_args(hint), *(part for one in get_args(hint) for part in get_args(one))}


def refuse(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """What a wrong input gets; empty where it is answered as it must be, else what is wrong with the answer."""
    before, start = listing(), time.monotonic()
    try:
        main(words)
        code: Any = "no exit"
    except SystemExit as left:
        code = left.code
    took, shown, after = time.monotonic() - start, capsys.readouterr(), listing()
    message = shown.err.strip()
    wrong = [
        f"exit code {code}" if code != 2 else "",
        "something on standard output" if shown.out else "",
        f"{len(message.splitlines())} lines" if len(message.splitlines()) > 12 else "",
        "no sentence" if not message.startswith("Error: ") or len(message) < 20 else "",
        "no code" if not re.search(r" \[[a-z0-9]+([-_][a-z0-9]+)*\]$", message, re.M) else "",
        f"{took:.1f} s" if took > LONGEST_S else "",
        f"leaves {', '.join(after - before)}" if after - before else "",
    ]
    faults = "; ".join(fault for fault in wrong if fault)
    return f"{' '.join(words)}: {faults}: {message[:300]}" if faults else ""


def listing() -> set[str]:
    return {str(path) for path in Path().rglob("*")}


def split(text: str) -> dict[str, list[str]]:
    """Words of a command by flag; those before the first flag stand under an empty name."""
    found: dict[str, list[str]] = {"": []}
    flag = ""
    for word in shlex.split(text):
        if word.startswith("--"):
            flag = word
            found[flag] = []
        else:
            found[flag].append(word)
    return found


def command(name: str, house: dict[str, Path], change: str = "", words: str = "") -> list[str]:
    """Words of a command as its row has them, or those given, with some of its flags changed or added."""
    changed = {flag: values for flag, values in split(change).items() if flag or values}
    flags = split(words or ROWS[name].words) | changed
    all_words = [word for flag, values in flags.items() for word in ([flag] if flag else []) + values]
    return [*name.split(), *(word.format(**house) if "{" in word else word for word in all_words)]


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    with pytest.MonkeyPatch.context() as changes:
        leave_out_pictures(changes)
        return furnish(tmp_path_factory.mktemp("house"))


@pytest.fixture(autouse=True)
def _flags_are_assembled_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Thousands of attempts parse the same commands: flags and checks of types are made once for all attempts."""
    assemble = App.assemble_argument_collection

    def again(command: App, **chosen: Any) -> ArgumentCollection:
        place = command.default_command, tuple(chosen.items())
        if place not in ASSEMBLED:
            ASSEMBLED[place] = assemble(command, **chosen)
        return copy_arguments(ASSEMBLED[place])

    monkeypatch.setattr(App, "assemble_argument_collection", again)
    monkeypatch.setattr(pydantic, "TypeAdapter", ADAPTER)


def copy_arguments(found: ArgumentCollection) -> ArgumentCollection:
    """Arguments without words yet; what describes them is shared."""
    copies = {id(one): copy.copy(one) for one in found}
    for one in copies.values():
        one.tokens = []
        one.children = ArgumentCollection([copies[id(child)] for child in one.children])
    return ArgumentCollection(copies.values())


@pytest.fixture(autouse=True)
def _nothing_is_computed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A door that lets a wrong input in would press, train or serve: that is seen at once, by the exit code."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("palpate.mechanics.kernels_compiled", lambda: True)  # else a line announces their compilation
    for module, heavy, verb in HEAVY:
        monkeypatch.setattr(getattr(import_module(f"palpate.{module}"), heavy), verb, compute)


def compute(*_: object, **__: object) -> None:
    raise RuntimeError("a wrong input was let in, and something is computed")


def check(attempts: list[list[str]], capsys: pytest.CaptureFixture[str]) -> None:
    faults = [fault for words in attempts if (fault := refuse(words, capsys))]
    assert not faults, "\n" + "\n".join(faults)


def test_every_command_and_every_path_has_a_row() -> None:
    assert set(ROWS) == set(COMMANDS)
    for name, row in ROWS.items():
        paths = {flag for flag, argument in arguments_of(name) if Path in kinds_of(argument)}
        assert paths <= {*row.files, *row.outputs}, name


@pytest.mark.parametrize("name", [name for name in ROWS if name not in SLOW])
def test_what_is_right_is_let_in(
    name: str, house: dict[str, Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if name == "view":
        needs("nicegui")
    monkeypatch.setattr(ImageRidge, "sides", (16,))
    with pytest.raises(SystemExit) as left:
        main(command(name, house))
    assert left.value.code in (0, 1), capsys.readouterr().err


@pytest.mark.parametrize("name", ROWS)
def test_a_number_that_is_none_or_out_of_bounds_is_refused(
    name: str, house: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    numbers = [(flag, argument) for flag, argument in arguments_of(name) if kinds_of(argument) & {int, float}]
    attempts = []
    for flag, argument in numbers:
        may_be_empty = type(None) in kinds_of(argument)  # an empty text is none where a number may be left open
        wrong = ("nan", "inf", "-1e99", "text", *(() if may_be_empty else ("",)))
        attempts += [command(name, house, f"{flag} '{value}'") for value in wrong]
    check(attempts, capsys)


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if row.files])
def test_a_wrong_file_is_refused(name: str, house: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    kinds = ("nowhere", "empty", "folder", "text", "noise", "half")
    change = [
        f"{flag if flag.startswith('-') else ''} {{{kind}}}"
        for flag in ROWS[name].files
        for kind in kinds
        if kind not in ROWS[name].skip.get(flag, ())
    ]
    check([command(name, house, one, ROWS[name].few) for one in change], capsys)


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if row.outputs])
def test_an_output_that_cannot_be_written_is_refused_before_anything_is_computed(
    name: str, house: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    places = []
    for flag in ROWS[name].outputs:
        file = ending_of(name, flag)
        places += [f"{flag} {{text}}/{file}", f"{flag} {'{folder}' if Path(file).suffix else '{text}'}"]
    check([command(name, house, one) for one in places], capsys)


def ending_of(name: str, flag: str) -> str:
    folders = (
        "calibration accept --out",
        "calibration identify --report",
        "sensor check --out",
        "press --export",
        "design profile --out",
        "claims --figures",
    )
    if f"{name} {flag}" in folders:
        return "new"
    return {"--figure": "a.png", "--picture": "a.png", "--print-board": "a.pdf"}.get(
        flag, Path(split(ROWS[name].words).get(flag, ["a.csv"])[0]).name
    )


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if row.against])
def test_words_that_contradict_each_other_are_refused(
    name: str, house: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    check([command(name, house, one) for one in ROWS[name].against], capsys)
