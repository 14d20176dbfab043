"""Flags that people have typed stay: names, defaults and units of every command, as they were once written down.

A new flag needs no row in ``flags.csv``; an old one that goes, or whose default changes, is seen here.
"""

import csv
import json
from collections import defaultdict
from pathlib import Path

import pytest
from command_table import list_commands, list_flags

COMMANDS = dict(list_commands())


def known_flags() -> dict[str, dict[str, tuple[object, str]]]:
    known: dict[str, dict[str, tuple[object, str]]] = defaultdict(dict)
    with (Path(__file__).parent / "flags.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            known[row["command"]][row["flag"]] = (json.loads(row["default"]), row["unit"])
    return known


@pytest.mark.parametrize(("command", "flags"), known_flags().items())
def test_flags_keep_their_names_defaults_and_units(command: str, flags: dict[str, tuple[object, str]]) -> None:
    found = list_flags(COMMANDS[command])
    assert set(found) >= set(flags)
    for name, (default, unit) in flags.items():
        assert found[name]["default"] == default, name
        assert not unit or f"({unit}" in found[name]["help"], name


@pytest.mark.parametrize("command", COMMANDS)
def test_no_two_fields_of_a_command_share_a_flag(command: str) -> None:
    collection = COMMANDS[command].assemble_argument_collection()
    names = [name for argument in collection if argument.parse and not argument.children for name in argument.names]
    assert len(names) == len(set(names))


def test_out_is_o_at_every_command() -> None:
    flags = {name: set(list_flags(command)) for name, command in COMMANDS.items()}
    assert [name for name, names in flags.items() if "--out" in names and "-o" not in names] == []


@pytest.mark.parametrize("command", COMMANDS)
def test_every_flag_is_in_the_help(command: str) -> None:
    collection = COMMANDS[command].assemble_argument_collection()
    used = [argument for argument in collection if argument.parse and not argument.children]
    assert [one.name for one in used if not (one.parameter.help and one.parameter.group and one.show)] == []
