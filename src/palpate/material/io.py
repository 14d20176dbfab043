"""Write and read a material: one YAML file, as in the library."""

from __future__ import annotations

import math
from io import StringIO
from numbers import Real
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from palpate.core import PalpateError, wrap_write_errors
from palpate.material.make_law import LAWS
from palpate.material.material import DEFAULT_BULK_RATIO, Material
from palpate.material.relaxation import Moduli, Relaxation

_TEXTS = ("source", "licence", "quality", "caution")
_KEYS = ("name", "law", "constants", "bulk_ratio", "stretch_range", "relaxation", *_TEXTS)
_TERM = {"share", "time"}
_HEAD = "# A material of palpate. Constants in MPa; exponents alpha, Jm and lm are pure numbers.\n"
_RELAXATION = "Write moduli (long-term or instantaneous) and terms, each {share: 0.1, time: 3.0}, time in s."


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
    if material.relaxation is not None:
        content["relaxation"] = _relaxation_data(material.relaxation)
    content |= {key: getattr(material, key) for key in _TEXTS if getattr(material, key)}
    text = StringIO()
    writer = YAML()
    writer.width = 110
    writer.dump(content, text)
    with wrap_write_errors(path, "Name a file in an existing folder."):
        path.write_text(_HEAD + text.getvalue(), encoding="utf-8")


def read_material(path: Path) -> Material:
    """Read a material.

    Raises
    ------
    PalpateError
        If the file cannot be read or is not a material; the message names file and key.
    """
    try:
        text = path.read_text("utf-8")
    except UnicodeDecodeError:
        raise PalpateError(
            f"{path} is not a text file.",
            "Give a YAML file that `palpate material fit -o` wrote.",
            code="file-not-text",
        ) from None
    except OSError as error:
        raise PalpateError(
            f"The material file {path} cannot be read: {error.strerror}.",
            "Give a file that `palpate material fit -o` wrote.",
            code="file-unreadable",
        ) from None
    return parse_material(text, str(path))


def parse_material(text: str, name: str) -> Material:
    """Read a material from the text of its file.

    Parameters
    ----------
    text
        YAML.
    name
        Name of the file, for errors.
    """
    try:
        content = YAML(typ="safe", pure=True).load(text)
    except MarkedYAMLError as error:
        line = f":{error.problem_mark.line + 1}" if error.problem_mark is not None else ""
        raise PalpateError(
            f"{name}{line}: this is not YAML: {error.problem}.", "Correct the line.", code="yaml-malformed"
        ) from None
    except (YAMLError, RecursionError):
        raise PalpateError(f"{name}: this is not YAML.", "Correct the file.", code="yaml-malformed") from None
    if not isinstance(content, dict) or not {"name", "law", "constants"} <= set(content):
        raise PalpateError(
            f"{name} is no material file.",
            "It needs name, law and constants; see `palpate material fit -o`.",
            code="material-file-malformed",
        )
    unknown = [str(key) for key in content if key not in _KEYS]
    if unknown:
        raise PalpateError(f"{name}: there is no key {unknown[0]}.", f"Keys: {', '.join(_KEYS)}.", code="key-unknown")
    return _make(content, name)


def _make(content: dict[str, Any], name: str) -> Material:
    constants = content["constants"]
    if not isinstance(constants, dict):
        raise PalpateError(
            f"{name}: constants are no mapping.",
            "Write each on a line of its own, C10: 0.0141.",
            code="constants-not-mapping",
        )
    numbers = {str(key): _number(value, f"constants.{key}", name) for key, value in constants.items()}
    ends = content.get("stretch_range", [0.0, math.inf])
    if not isinstance(ends, list) or len(ends) != 2:
        raise PalpateError(
            f"{name}: stretch_range is not two numbers.", "Write [0.5, 5.0].", code="stretch-range-malformed"
        )
    low, high = (_number(end, "stretch_range", name, finite=False) for end in ends)
    texts: dict[str, Any] = {key: str(content.get(key, "")).strip() for key in _TEXTS}
    try:
        return Material(
            name=str(content["name"]),
            law=LAWS.get(str(content["law"])).from_constants(numbers),
            bulk_ratio=_number(content.get("bulk_ratio", DEFAULT_BULK_RATIO), "bulk_ratio", name),
            stretch_range=(low, high),
            relaxation=_read_relaxation(content["relaxation"], name) if "relaxation" in content else None,
            **texts,
        )
    except PalpateError as error:
        raise PalpateError(f"{name}: {error.problem}", error.remedy, code=error.code) from None


def _relaxation_data(relaxation: Relaxation) -> dict[str, Any]:
    terms = zip(relaxation.shares, relaxation.times, strict=True)
    return {
        "moduli": str(relaxation.moduli),
        "terms": [{"share": float(share), "time": float(time)} for share, time in terms],
    }


def _read_relaxation(content: Any, name: str) -> Relaxation:
    """A relaxation as moduli and terms, or as a list of terms alone."""
    found = {"terms": content} if isinstance(content, list) else content
    if not isinstance(found, dict) or not {"terms"} <= set(found) <= {"moduli", "terms"}:
        raise PalpateError(f"{name}: relaxation is no list of terms.", _RELAXATION, code="relaxation-not-list")
    terms, moduli = found["terms"], str(found.get("moduli", Moduli.LONG_TERM))
    if not isinstance(terms, list) or any(not isinstance(term, dict) or set(term) != _TERM for term in terms):
        raise PalpateError(
            f"{name}: a term of relaxation is no pair of share and time.",
            _RELAXATION,
            code="relaxation-term-malformed",
        )
    if moduli not in list(Moduli):
        raise PalpateError(
            f"{name}: relaxation.moduli is {moduli!r}.", f"Choose one of {', '.join(Moduli)}.", code="moduli-unknown"
        )
    shares, times = (
        tuple(_number(term[key], f"relaxation.terms[{at}].{key}", name) for at, term in enumerate(terms, start=1))
        for key in ("share", "time")
    )
    return Relaxation(shares, times, Moduli(moduli))


def _number(value: Any, key: str, name: str, *, finite: bool = True) -> float:
    if isinstance(value, bool) or not isinstance(value, Real) or (finite and not math.isfinite(value)):
        raise PalpateError(f"{name}: {key} is {value!r}.", "Write a number.", code="value-not-number")
    return float(value)
