"""From the text a person writes to a material."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from typing import Any

from palpate.core import PalpateError
from palpate.material.law import Law, Polynomial, mooney_rivlin, neo_hooke, ogden, yeoh
from palpate.material.library import LIBRARY
from palpate.material.material import Material

_LAWS: dict[str, tuple[Callable[..., Law], tuple[int, ...], str]] = {
    "yeoh": (yeoh, (3,), "C10,C20,C30"),
    "neo-hooke": (neo_hooke, (1,), "C10"),
    "mooney-rivlin": (mooney_rivlin, (2,), "C10,C01"),
    "ogden": (ogden, (2, 4, 6), "mu1,alpha1[,mu2,alpha2[,mu3,alpha3]]"),
}


def list_materials() -> tuple[str, ...]:
    """Names in the library."""
    return tuple(sorted(LIBRARY))


def get_material(text: str) -> Material:
    """Get a material by its name in the library or by law and constants.

    Parameters
    ----------
    text
        ``zaid_2024_ecoflex_00_30`` or ``yeoh:0.0141156,0.0001106,0.0000048`` (MPa); also ``neo-hooke:C10``,
        ``mooney-rivlin:C10,C01`` and ``ogden:mu1,alpha1,…``.

    Raises
    ------
    PalpateError
        If there is no such material or law, or the constants are not numbers of the right count.
    """
    text = text.strip()
    if text in LIBRARY:
        return LIBRARY[text]
    law, colon, numbers = text.partition(":")
    if not colon or law not in _LAWS:
        near = get_close_matches(text if not colon else law, [*LIBRARY, *_LAWS], n=1, cutoff=0.3)
        hint = f"Did you mean {near[0]}? " if near else ""
        laws = ", ".join(f"{name}:{form}" for name, (_, _, form) in _LAWS.items())
        raise PalpateError(
            f"There is no material '{text}'.",
            f"{hint}Known: {', '.join(list_materials())}; or {laws} in MPa.",
        )
    make, counts, form = _LAWS[law]
    try:
        constants = [float(number) for number in numbers.split(",")]
    except ValueError:
        raise PalpateError(f"'{numbers}' are not numbers.", f"Write {law}:{form} in MPa.") from None
    if len(constants) not in counts:
        raise PalpateError(f"{law} takes {form}, but {len(constants)} numbers were given.", "Write them in MPa.")
    return Material(name=text, law=make(*constants))


def material_from_data(data: dict[str, Any]) -> Material:
    """Make a material again from `Material.key_data` and its ``name``.

    Parameters
    ----------
    data
        With ``name``, ``law``, ``constants`` (MPa) and ``bulk_ratio``.
    """
    constants, law = data["constants"], data["law"]
    if law == "ogden":
        made: Law = ogden(*(constants[key] for key in sorted(constants, key=lambda key: (key[-1], key[0] != "m"))))
    else:
        made = Polynomial(law, **{key.lower(): value for key, value in constants.items()})
    known = LIBRARY.get(data["name"])
    source = known.source if known is not None else ""
    stretch_range = known.stretch_range if known is not None else (0.0, float("inf"))
    return Material(data["name"], made, data["bulk_ratio"], source, stretch_range)
