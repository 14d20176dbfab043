"""`palpate material`: the library of cured elastomers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any

from cyclopts import Parameter

from palpate.cli.output import JsonOutput, Output
from palpate.core.report import Column, Report
from palpate.material import Material, find_stable_ranges, get_material, list_materials

_COLUMNS = (
    Column("name"),
    Column("law"),
    Column("young_kpa", "Young's modulus", form=".1f", meaning="initial Young's modulus"),
    Column("stretch", meaning="range of the uniaxial stretch of the tests"),
    Column("stable", meaning="Drucker stability in all modes", prose=True, deciding=False),
    Column("quality", "fit", prose=True, deciding=False),
)
_NAME = "Name in the library, material file (.yaml), or law and constants (yeoh:C10,C20,C30 in MPa)."


def list_library(*, output: Output = Output()) -> None:
    """List the materials of the library."""
    facts = [describe_material(get_material(name)) for name in list_materials()]
    rows = [
        item
        | {
            "young_kpa": 1e3 * item["young_modulus_mpa"],
            "stretch": _range(item["stretch_range"]),
            "stable": _stable(item),
        }
        for item in facts
    ]
    output.show(facts, Report("materials", _COLUMNS, rows))


def show(name: Annotated[str, Parameter(help=_NAME)], *, output: JsonOutput = JsonOutput()) -> None:
    """Show a material: constants, moduli, range, stability, source and licence."""
    facts = describe_material(get_material(name))
    output.show(facts, *_sentences(facts))


def _sentences(facts: dict[str, Any]) -> Iterator[str]:
    yield f"{facts['name']}: {facts['law']}"
    for key, value in facts["constants"].items():
        yield f"  {key} = {value:.8g}"
    yield (
        f"initial E {1e3 * facts['young_modulus_mpa']:.4g} kPa, mu {1e3 * facts['shear_modulus_mpa']:.4g} kPa; "
        f"K/mu {facts['bulk_ratio']:g}, Poisson's ratio {facts['poisson_ratio']:.5f}"
    )
    yield f"uniaxial stretch {_range(facts['stretch_range'])}; Drucker-stable: {_stable(facts)}"
    if facts["relaxation"]:
        series = facts["relaxation"]
        terms = ", ".join(f"{a:.4g} in {b:.4g} s" for a, b in zip(series["shares"], series["times"], strict=True))
        yield f"relaxation, moduli {series['moduli']}: shares {terms}"
    for key in ("source", "licence", "quality", "caution"):
        if facts[key]:
            yield f"{key}: {facts[key]}"


def describe_material(material: Material) -> dict[str, Any]:
    """Return a material as JSON data."""
    ranges = find_stable_ranges(material.law)
    return {
        "name": material.name,
        "law": material.law.name,
        "constants": material.law.constants,
        "shear_modulus_mpa": material.law.shear_modulus,
        "young_modulus_mpa": material.young_modulus,
        "bulk_ratio": material.bulk_ratio,
        "poisson_ratio": material.poisson_ratio,
        "stretch_range": list(material.stretch_range),
        "relaxation": material.relaxation.key_data() if material.relaxation is not None else None,
        "stable": all(item.whole for item in ranges),
        "locks_at": {str(item.mode): item.high for item in ranges if item.high_locks},
        "source": material.source,
        "licence": material.licence,
        "quality": material.quality,
        "caution": material.caution,
    }


def _stable(facts: dict[str, Any]) -> str:
    if facts["locks_at"]:
        return "until it locks, " + ", ".join(f"{mode} at {end:.4g}" for mode, end in facts["locks_at"].items())
    return "yes" if facts["stable"] else "NO"


def _range(ends: list[float]) -> str:
    low, high = ends
    return f"{low:.3g} to {high:.3g}" if math.isfinite(high) else "unknown"
