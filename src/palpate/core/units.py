"""Units in tables: in brackets, at the end of a name, or in a separate row."""

from __future__ import annotations

import re
from functools import lru_cache

_ONE = (
    r"(?:%|‰|°|[µμu](?:ε|[sS]train)|ue|[mM]icrostrain|[kMGmµμuc]?(?:Pa|N|m|g|s|V|A|Hz|rad|J|W)|in(?:ch(?:es)?)?|ft|psi|ksi|bar|kgf|gf|kp|lbf?|ozf?|[sS]ec|[sS]ek|SEC"
    r"|[kmKM]?[nN][-·*.]?[mM]{1,2}|min|h|hr|hours?|minutes?|seconds?|deg(?:rees?)?|radians?|°[CF]|[CKF]|stretch|log|percent|pct|px|mpa|kpa|PSI"
    r"|MPA|KPA|pa|PA|n|kn|KN|kgf|Kgf|KGF|LBF|Lbf|MM|Mm|秒|毫米|兆帕|千帕|牛|牛顿|百分比|度|弧度)"
)
_WHOLE = re.compile(rf"{_ONE}(?:\^?[23²³])?(?:[/·*. ]{_ONE}(?:\^?[23²³])?)*|1/s|-|–|1")
_BRACKETS = re.compile(r"\s*[\(\[<（【]\s*([^()\[\]<>（）【】]*?)\s*[\)\]>）】]")
_TAIL = re.compile(r"^(.*?\S)(?:_|\s+in\s+|\s*/\s*|\s*,\s*|\s*:\s*|\s+)([^\s_,]+)$", re.I)
_SHORT_TEST = re.compile(r"[ _-](?:ut|uc|et|ps)\d*$", re.I)
"""Short name of a material test after the unit in a column's name."""


@lru_cache(maxsize=4096)
def is_unit(text: str) -> bool:
    """Whether a text is a unit, without brackets or in them."""
    return bool(_WHOLE.fullmatch(text.strip("()[]{}<>（）【】 ")))


def split_unit(name: str) -> tuple[str, str]:
    """Split a column's name into bare name and unit, which may be empty.

    ``Stress [kPa]``, ``force (N)``, ``Kraft in N``, ``strain_%``, ``depth / mm`` and ``rx_deg`` are understood.
    """
    bare = _SHORT_TEST.sub("", name.strip())
    for found in reversed(list(_BRACKETS.finditer(bare))):
        if is_unit(found[1]) or not _WHOLE.search(bare[: found.start()]):
            return (bare[: found.start()] + bare[found.end() :]).strip(), found[1]
    tail = _TAIL.match(bare)
    if tail and is_unit(tail[2]) and tail[2] not in ("-", "1"):
        return tail[1].strip(), tail[2]
    return bare, ""


def split_lower(name: str) -> tuple[str, str]:
    """Split a column's name as `split_unit`, and return both parts in lower case.

    The unit is read in the case of the name first: ``mN`` is known by its capital, ``MM`` in lower case only.
    """
    bare, unit = split_unit(name)
    return (bare.lower(), unit.lower()) if unit else split_unit(name.lower())
