"""Material from its name, its file, or a law with constants."""

from __future__ import annotations

from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import PalpateError
from palpate.material.io import read_material
from palpate.material.law import Model
from palpate.material.library import library_names, read_library
from palpate.material.make_law import LAWS, get_model, list_models
from palpate.material.material import Material
from palpate.material.relaxation import Relaxation

FILE_ENDINGS = (".yaml", ".yml")
"""Endings by which a text is known to name a material file."""


def list_materials() -> tuple[str, ...]:
    """Names in the library."""
    return library_names()


def get_material(text: str) -> Material:
    """Get a material by its name in the library, by its file, or by law and constants.

    Parameters
    ----------
    text
        ``zaid_2024_ecoflex_00_30``; or the path of a file, ``mine.yaml``; or ``yeoh:0.0141156,0.0001106,0.0000048``
        (MPa), also ``neo-hooke:C10``, ``mooney-rivlin:C10,C01``, ``gent:mu,Jm``, ``arruda-boyce:mu,lm`` and
        ``ogden:mu1,alpha1,…``, and every model of `list_models`, such as ``ogden-2:mu1,alpha1,mu2,alpha2``.

    Raises
    ------
    PalpateError
        If there is no such material, file or law, or the constants are not numbers of the right count.
    """
    text = text.strip()
    if text in library_names():
        return read_library(text)
    if text.endswith(FILE_ENDINGS):
        return read_material(Path(text))
    law, colon, numbers = text.partition(":")
    model = get_model(law) if colon and law not in LAWS and law in list_models() else None
    if not colon or (law not in LAWS and model is None):
        near = get_close_matches(text if not colon else law, [*library_names(), *LAWS.names], n=1, cutoff=0.5)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise PalpateError(
            f"There is no material '{text}'.",
            f"{hint}Give a name of `palpate material list`, LAW:CONSTANTS in MPa ({', '.join(LAWS.names)}), or a "
            "material file (.yaml).",
            code="material-unknown",
        )
    names = LAWS.get(law).constants_text() if model is None else ",".join(_constants(model))
    try:
        constants = [float(number) for number in numbers.split(",")]
    except ValueError:
        raise PalpateError(
            f"'{numbers}' are not numbers.", f"Write {law}:{names} in MPa.", code="constants-not-numbers"
        ) from None
    if model is None:
        return Material(name=text, law=LAWS.get(law).from_numbers(constants))
    if len(constants) != len(_constants(model)):
        raise PalpateError(
            f"'{law}' has {len(_constants(model))} constants; got {len(constants)}.",
            f"Write {law}:{names} in MPa.",
            code="constants-count-wrong",
        )
    values = dict(zip(_constants(model), constants, strict=True))
    linear, shapes = (np.array([values[name] for name in part]) for part in (model.linear, model.shapes))
    return Material(name=text, law=model.law(linear, shapes))


def _constants(model: Model) -> tuple[str, ...]:
    """Return a fitted model's constants in the order of its law: mu1, alpha1, mu2, … of Ogden."""
    pairs = zip(model.linear, model.shapes, strict=True) if model.shapes else ((name,) for name in model.linear)
    return tuple(name for pair in pairs for name in pair)


def material_from_data(data: dict[str, Any]) -> Material:
    """Make a material again from `Material.key_data` and its ``name``.

    Parameters
    ----------
    data
        With ``name``, ``law``, ``constants`` (MPa) and ``bulk_ratio``; ``relaxation`` if it relaxes, ``gel`` if
        filled.
    """
    if "gel" in data:
        wall = {name: value for name, value in data.items() if name != "gel"}
        return replace(material_from_data(wall), gel=material_from_data(data["gel"]))
    relaxation = Relaxation.from_data(data["relaxation"]) if "relaxation" in data else None
    made = LAWS.get(data["law"]).from_constants(data["constants"])
    if data["name"] not in library_names():
        return Material(data["name"], made, data["bulk_ratio"], relaxation=relaxation)
    known = read_library(data["name"])
    return replace(known, law=made, bulk_ratio=data["bulk_ratio"], relaxation=relaxation)
