"""Material of a deck: hyperelastic laws in the constants of Abaqus and CalculiX, which agree.

Both use ``W = W_iso + sum_i (J - 1)^(2 i) / D_i``, so ``D1 = 2 / K`` is the volumetric part of
`palpate.material.Material`. Arruda and Boyce's law alone has ``((J² - 1) / 2 - ln J) / D``, which is equal to second
order. Each law provides its constants (`palpate.material.Law.deck`).
"""

from __future__ import annotations

from collections.abc import Iterator

from palpate.core import PalpateError
from palpate.fea.deck_spec import Dialect
from palpate.material import Law, Material, Relaxation

_PER_LINE = 8
"""Maximum number of constants in a line."""

_NO_TERM = {Dialect.ABAQUS: 0.0, Dialect.CALCULIX: 1e12}
"""D2 and D3 that omit their terms: 0 in Abaqus; CalculiX would replace 0 by its own default."""


def material_lines(material: Material, dialect: Dialect, name: str = "SILICONE") -> Iterator[str]:
    """Yield the lines of the material, and of one named FILLING if it has a gel filling.

    Raises
    ------
    PalpateError
        If no dialect has the law.
    """
    model, constants = hyperelastic(material.law, 2.0 / material.bulk_modulus, _NO_TERM[dialect])
    yield f"** Material: {material.name}" + (f" ({material.source})" if material.source else "")
    yield f"** law {material.law.name}, " + ", ".join(f"{k} = {v:.8g}" for k, v in material.law.constants.items())
    yield (
        f"** volumetric part K/2 (J-1)^2, K = {material.bulk_modulus:.6g} MPa = {material.bulk_ratio:g} mu "
        f"(Poisson's ratio {material.poisson_ratio:.6f}): D1 = 2/K"
    )
    yield f"*MATERIAL, NAME={name}"
    yield f"*HYPERELASTIC, {model}"
    for at in range(0, len(constants), _PER_LINE):
        yield ", ".join(f"{value:.10g}" for value in constants[at : at + _PER_LINE])
    if material.relaxation is not None:
        yield from _relaxation_lines(material.relaxation, dialect)
    if material.gel is not None:
        yield from material_lines(material.gel, dialect, "FILLING")


def _relaxation_lines(relaxation: Relaxation, dialect: Dialect) -> Iterator[str]:
    """Yield relaxation as comments: the deck is elastic, and its pseudo-time is depth, not seconds."""
    yield f"** The press is elastic, of the {relaxation.moduli} moduli above; the material relaxes:"
    if dialect is Dialect.CALCULIX:
        terms = zip(relaxation.shares, relaxation.times, strict=True)
        yield "** " + ", ".join(f"share {share:.8g} in {time:.8g} s" for share, time in terms)
        yield "** CalculiX cannot combine viscoelasticity with *HYPERELASTIC: left out"
        return
    yield f"** for a step *VISCO in s, add MODULI={relaxation.moduli.upper().replace('-', ' ')} to *HYPERELASTIC, and"
    yield "** *VISCOELASTIC, TIME=PRONY"
    for share, time in zip(relaxation.shares, relaxation.times, strict=True):
        yield f"** {share:.10g}, 0., {time:.10g}"


def hyperelastic(law: Law, d1: float, no_term: float = 0.0) -> tuple[str, list[float]]:
    """Return the parameter of ``*HYPERELASTIC`` and its constants (MPa; D in 1/MPa).

    `no_term` is used for D2 and D3.

    Raises
    ------
    PalpateError
        If neither dialect has the law.
    """
    line = law.deck()
    if line is None:
        raise PalpateError(
            f"The law {law.name} has no counterpart in Abaqus and CalculiX.",
            "Fit another law to its curve: yeoh, ogden or arruda-boyce (`palpate material fit`).",
            code="law-not-in-deck",
        )
    return line.parameter, [*line.constants, d1, *[no_term] * (line.volumetric - 1)]
