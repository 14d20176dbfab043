"""Write and read a material: one YAML file, as in the library."""

from __future__ import annotations

import math
from io import StringIO
from numbers import Real
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from palpate.core import PalpateError, writing
from palpate.material.make_law import LAWS
from palpate.material.material import DEFAULT_BULK_RATIO, Material

_TEXTS = ("source", "licence", "quality", "caution")
_KEYS = ("name", "law", "constants", "bulk_ratio", "stretch_range", *_TEXTS)
_HEAD = "# A material of palpate. Constants in MPa; exponents alpha, Jm and lm are pure numbers.\n"


def write_material(path: Path, material: Material) -> None:
    """Write a material.

    Raises
    ------
    PalpateError
        If the file cannot be written.
    """
    content: dict[str, Any] = {
        "name": material.name,
        "law": material.law.name,
        "constants": {key: float(value) for key, value in material.law.constants.items()},
        "bulk_ratio": float(material.bulk_ratio),
    }
    if all(math.isfinite(end) for end in material.stretch_range):
        content["stretch_range"] = [float(f"{end:.6g}") for end in material.stretch_range]
    content |= {key: getattr(material, key) for key in _TEXTS if getattr(material, key)}
    text = StringIO()
    writer = YAML()
    writer.width = 110
    writer.dump(content, text)
    with writing(path, "Name a file in an existing folder."):
        path.write_text(_HEAD + text.getvalue(), encoding="utf-8")


def read_material(path: Path) -> Material:
    """Read a material.

    Raises
    ------
    PalpateError
        If the file cannot be read or is no material; the message names file and key.
    """
    try:
        text = path.read_text("utf-8")
    except UnicodeDecodeError:
        raise PalpateError(f"{path} is not a text file.", "Give a YAML file that `palpate fit -o` wrote.") from None
    except OSError as error:
        raise PalpateError(
            f"The material file {path} cannot be read: {error.strerror}.", "Give a file that `palpate fit -o` wrote."
        ) from None
    return parse_material(text, str(path))


def parse_material(text: str, name: str) -> Material:
    """Read a material from the text of its file.

    Parameters
    ----------
    text
        YAML.
    name
        Of the file, for errors.
    """
    try:
        content = YAML(typ="safe", pure=True).load(text)
    except MarkedYAMLError as error:
        line = f":{error.problem_mark.line + 1}" if error.problem_mark is not None else ""
        raise PalpateError(f"{name}{line}: this is not YAML: {error.problem}.", "Mend the line.") from None
    except (YAMLError, RecursionError):
        raise PalpateError(f"{name}: this is not YAML.", "Mend the file.") from None
    if not isinstance(content, dict) or not {"name", "law", "constants"} <= set(content):
        raise PalpateError(f"{name} is no material file.", "It needs name, law and constants; see `palpate fit -o`.")
    unknown = [str(key) for key in content if key not in _KEYS]
    if unknown:
        raise PalpateError(f"{name}: there is no key {unknown[0]}.", f"Keys: {', '.join(_KEYS)}.")
    return _make(content, name)


def _make(content: dict[str, Any], name: str) -> Material:
    constants = content["constants"]
    if not isinstance(constants, dict):
        raise PalpateError(f"{name}: constants are no mapping.", "Write each on a line of its own, C10: 0.0141.")
    numbers = {str(key): _number(value, f"constants.{key}", name) for key, value in constants.items()}
    ends = content.get("stretch_range", [0.0, math.inf])
    if not isinstance(ends, list) or len(ends) != 2:
        raise PalpateError(f"{name}: stretch_range is not two numbers.", "Write [0.5, 5.0].")
    low, high = (_number(end, "stretch_range", name, finite=False) for end in ends)
    texts: dict[str, Any] = {key: str(content.get(key, "")).strip() for key in _TEXTS}
    try:
        return Material(
            name=str(content["name"]),
            law=LAWS.get(str(content["law"])).from_constants(numbers),
            bulk_ratio=_number(content.get("bulk_ratio", DEFAULT_BULK_RATIO), "bulk_ratio", name),
            stretch_range=(low, high),
            **texts,
        )
    except PalpateError as error:
        raise PalpateError(f"{name}: {error.what}", error.remedy) from None


def _number(value: Any, key: str, name: str, *, finite: bool = True) -> float:
    if isinstance(value, bool) or not isinstance(value, Real) or (finite and not math.isfinite(value)):
        raise PalpateError(f"{name}: {key} is {value!r}.", "Write a number.")
    return float(value)
