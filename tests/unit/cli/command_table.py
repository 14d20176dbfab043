"""Every command of `palpate`, read from the app itself, so that a new one is met by the tests of all."""

from collections.abc import Iterator
from typing import Any

from cyclopts import App
from cyclopts.argument import ArgumentCollection

from palpate.cli.app import app


def list_commands(part: App = app, words: tuple[str, ...] = ()) -> Iterator[tuple[str, App]]:
    """Name of every command as it is typed, and its app; `run` and `press` once, at the top."""
    for name in part:
        if name.startswith("-") or (words and name in app):
            continue
        inner = part[name]
        if inner.default_command is None:
            yield from list_commands(inner, (*words, name))
        else:
            yield " ".join((*words, name)), inner


def list_flags(command: App) -> dict[str, dict[str, Any]]:
    """Default and help text of every flag and argument of a command, by the name that is typed."""
    found: dict[str, dict[str, Any]] = {}
    collection: ArgumentCollection = command.assemble_argument_collection()
    for argument in collection:
        if not argument.parse or argument.children or not argument.show:
            continue
        names = [*argument.names, *argument.negatives]
        for name in names if names else [argument.field_info.name]:
            found[name] = {"default": _plain(argument.field_info.default), "help": argument.parameter.help or ""}
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, type):  # no default: it must be given
        return "required"
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value if value is None or type(value) in (bool, int, float, str) else str(value)
