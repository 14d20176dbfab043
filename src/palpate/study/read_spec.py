"""Reader of specs from YAML files; errors name file, line, bound and the nearest valid key."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from palpate.core import PalpateError, Spec, parameters

MOST_ERRORS = 8
"""Maximum number of reported errors."""


Place = tuple[str | int, ...]
Given = TypeVar("Given", bound=Spec)


def read_spec(
    path: Path, text: str, spec: type[Given], hint: str, resolve: Callable[[CommentedMap], None] | None = None
) -> Given:
    """Read a spec from the text of a YAML file.

    Parameters
    ----------
    path
        Origin of the text, for messages.
    text
        The file's content.
    spec
        Class of the spec.
    hint
        Place of a valid example, for messages.
    resolve
        Changes the file's tree before its validation, to include other files.

    Raises
    ------
    PalpateError
        If the file is invalid; the message names file and line.
    """
    name = spec.__name__.removesuffix("Spec").lower()
    try:
        tree = YAML(typ="rt").load(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark is not None else ""
        problem = str(error.problem or error.context).splitlines()[0]
        raise PalpateError(
            f"{path}{line}: this is not YAML: {problem}.", "Correct the line.", code="yaml-malformed"
        ) from error
    except YAMLError as error:
        raise PalpateError(
            f"{path}: this is not YAML: {error}.", "Correct the file.", code="yaml-malformed"
        ) from error
    except RecursionError:
        raise PalpateError(f"{path} is nested too deeply.", hint, code="yaml-too-deep") from None
    if not isinstance(tree, CommentedMap):
        raise PalpateError(f"{path}:1: a {name} is a mapping of keys.", hint, code="yaml-not-mapping")
    if resolve is not None:
        resolve(tree)
    try:
        return spec.model_validate(_plain(tree))
    except ValidationError as error:
        errors = sorted(error.errors(), key=lambda details: _line(tree, tuple(details["loc"])))
        lines = [_describe(path, tree, details, spec) for details in errors]
        more = [f"… and {len(lines) - MOST_ERRORS} more"] if len(lines) > MOST_ERRORS else []
        raise PalpateError("\n".join([*lines[:MOST_ERRORS], *more]), code=errors[0]["type"]) from None


def _plain(node: Any) -> Any:
    """Return mappings, lists and scalars without the reader's annotations."""
    if isinstance(node, CommentedMap):
        return {str(key): _plain(value) for key, value in node.items()}
    if isinstance(node, CommentedSeq):
        return [_plain(value) for value in node]
    for kind in (bool, int, float, str):
        if isinstance(node, kind):
            return kind(node)
    return node


def _describe(path: Path, tree: CommentedMap, details: ErrorDetails, spec: type[Spec]) -> str:
    place = tuple(_written_place(tree, details["loc"]))
    key = ".".join(str(part) for part in place) or spec.__name__.removesuffix("Spec").lower()
    where = f"{path}:{_line(tree, place)}: {key}"
    if details["type"] == "extra_forbidden":
        valid = list(_spec_at(spec, details["loc"][:-1]).model_fields)
        near = get_close_matches(str(place[-1]), valid, n=1, cutoff=0.5)
        hint = f"did you mean {near[0]}?" if near else f"valid keys: {', '.join(valid)}."
        return f"{where}: there is no such key; {hint}"
    if details["type"] == "missing":
        return f"{where} is missing."
    return f"{Spec.describe_value(details, where, _unit(spec, details['loc']))}."


def _written_place(tree: CommentedMap, place: Sequence[str | int]) -> Iterator[str | int]:
    """Part of an error's location that exists in the file; the rest names branches of the validation."""
    node: Any = tree
    for part in place:
        known = isinstance(node, CommentedMap) and part in node
        if not known and not (isinstance(node, CommentedSeq) and isinstance(part, int) and part < len(node)):
            if isinstance(node, CommentedMap) and len(place) == 1:
                yield part
            return
        yield part
        node = node[part]


def _line(tree: CommentedMap, place: Place) -> int:
    line, node = 0, tree
    for part in place:
        try:
            line = node.lc.key(part)[0] if isinstance(node, CommentedMap) else node.lc.item(part)[0]
            node = node[part]
        except (AttributeError, KeyError, IndexError, TypeError):
            break
    return int(line) + 1


def _spec_at(root: type[BaseModel], place: Sequence[str | int]) -> type[BaseModel]:
    """The spec that declares the keys at `place`."""
    spec = root
    for part in place:
        field = spec.model_fields.get(str(part))
        if field is not None:
            spec = next(_specs_in(field.annotation), spec)
    return spec


def _specs_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _specs_in(inner)


def _unit(root: type[BaseModel], place: Sequence[str | int]) -> str:
    names = [part for part in place if isinstance(part, str)]
    for depth in range(len(names), 0, -1):
        for note in parameters(_spec_at(root, names[: depth - 1])):
            if note.name == names[depth - 1]:
                return f" {note.unit}" if note.unit not in ("", "1") else ""
    return ""
