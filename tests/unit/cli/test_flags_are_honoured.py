"""A flag that a command takes does something there: its value is read on the way from the command to its work.

Every command's records of flags are followed through its source and that of the functions of its module that it
calls: a field is read where it, or the whole record, is handed to other code. What a record's `check` reads does not
count: refusing nonsense is no use of a value.
"""

import ast
import dataclasses
import inspect
import textwrap
import typing
from collections.abc import Callable

import pytest
from command_table import list_commands, list_flags

COMMANDS = {name: command.default_command for name, command in list_commands()}
UNKNOWN = [
    ("calibration predict", "--timeout"),
    ("calibration predict", "--cluster"),
    ("benchmark make", "--timeout"),
    ("benchmark baselines", "--cluster"),
    ("search", "--timeout"),
    ("calibration inspect", "--unit"),
    ("design stability", "--obstacle"),
    ("design convergence", "--cells"),
]


def records(command: typing.Any) -> list[tuple[str, type]]:
    """Parameters of a command that are records of flags."""
    hints = typing.get_type_hints(command)
    return [(name, kind) for name, kind in hints.items() if dataclasses.is_dataclass(kind)]


def fields_read(code: Callable[..., object], name: str, kind: type) -> set[str]:
    """Fields of a record that a function reads where the record is called `name`, and those that it calls."""
    tree, read = ast.parse(textwrap.dedent(inspect.getsource(code))), set[str]()
    fields = {field.name for field in dataclasses.fields(kind)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == name:
            read |= {node.attr} if node.attr in fields else read_by_method(kind, node.attr)
        if isinstance(node, ast.Call):
            given = [*enumerate(node.args), *((word.arg, word.value) for word in node.keywords)]
            for place, value in given:
                if isinstance(value, ast.Name) and value.id == name:
                    read |= read_by_call(code, node, place, kind)
    return read


def read_by_call(code: Callable[..., object], call: ast.Call, place: int | str | None, kind: type) -> set[str]:
    """Fields that a function of the module reads of a record that it is given whole; all where it is not known."""
    called = getattr(inspect.getmodule(code), ast.unparse(call.func), None)
    if not inspect.isfunction(called):
        return {field.name for field in dataclasses.fields(kind)}
    name = list(inspect.signature(called).parameters)[place] if isinstance(place, int) else place
    return fields_read(called, str(name), kind)


def read_by_method(kind: type, method: str) -> set[str]:
    """Fields of a record that one of its methods reads, but for that which refuses nonsense."""
    read: set[str] = set()
    for owner in kind.__mro__ if method != "check" else ():
        own = vars(owner).get(method)
        if own is not None:
            own = own.fget if isinstance(own, property) else own
            read |= fields_read(own, "self", kind)
            if "super()." not in inspect.getsource(own):
                break
    return read


@pytest.mark.parametrize("command", [name for name, command in COMMANDS.items() if records(command)])
def test_every_flag_of_a_command_is_read(command: str) -> None:
    function = COMMANDS[command]
    for name, kind in records(function):
        assert {field.name for field in dataclasses.fields(kind)} - fields_read(function, name, kind) == set(), name


@pytest.mark.parametrize(("command", "flag"), UNKNOWN)
def test_a_flag_that_does_nothing_is_unknown(command: str, flag: str) -> None:
    assert flag not in list_flags(dict(list_commands())[command])
