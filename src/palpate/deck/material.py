"""Material of a deck: hyperelastic laws in the constants of Abaqus and CalculiX, which agree.

Both write ``W = W_iso + sum_i (J - 1)^(2 i) / D_i``, so ``D1 = 2 / K`` is the volumetric part of
`palpate.material.Material`. Their Ogden is ``W = sum 2 mu_i / alpha_i² (l1^alpha_i + l2^alpha_i + l3^alpha_i - 3)``;
ours has ``mu / alpha`` in front, so ``mu_deck = mu alpha / 2``.
"""

from __future__ import annotations

from collections.abc import Iterator

from palpate.core import PalpateError
from palpate.deck.spec import Dialect
from palpate.material import Law, Material, Ogden, Polynomial

_PER_LINE = 8
"""Most constants of a line."""

_NO_TERM = {Dialect.ABAQUS: 0.0, Dialect.CALCULIX: 1e12}
"""D2 and D3 that leave their terms out: 0 in Abaqus, which CalculiX would replace by a default of its own."""


def material_lines(material: Material, dialect: Dialect) -> Iterator[str]:
    """Lines of the material SILICONE.

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
    yield "*MATERIAL, NAME=SILICONE"
    yield f"*HYPERELASTIC, {model}"
    for at in range(0, len(constants), _PER_LINE):
        yield ", ".join(f"{value:.10g}" for value in constants[at : at + _PER_LINE])


def hyperelastic(law: Law, d1: float, no_term: float = 0.0) -> tuple[str, list[float]]:
    """Parameter of ``*HYPERELASTIC`` and its constants (MPa; D in 1/MPa); `no_term` stands for D2 and D3.

    Raises
    ------
    PalpateError
        If neither dialect has the law.
    """
    if isinstance(law, Polynomial):
        return _polynomial(law, [d1, no_term, no_term])
    if isinstance(law, Ogden):
        terms = len(law.mu)
        pairs = [value for mu, a in zip(law.mu, law.alpha, strict=True) for value in (mu * a / 2, a)]
        return f"OGDEN, N={terms}", [*pairs, d1, *[no_term] * (terms - 1)]
    raise PalpateError(
        f"The law {law.name} has no counterpart in Abaqus and CalculiX.",
        "Choose a polynomial law (neo-hooke, mooney-rivlin, yeoh) or ogden.",
    )


def _polynomial(law: Polynomial, d: list[float]) -> tuple[str, list[float]]:
    only_first = law.c01 == law.c11 == law.c02 == 0
    if only_first and law.c20 == law.c30 == 0:
        return "NEO HOOKE", [law.c10, d[0]]
    if only_first:
        return "YEOH", [law.c10, law.c20, law.c30, *d]
    if law.c20 == law.c11 == law.c02 == law.c30 == 0:
        return "MOONEY-RIVLIN", [law.c10, law.c01, d[0]]
    first = [law.c10, law.c01, law.c20, law.c11, law.c02]
    if law.c30 == 0:
        return "POLYNOMIAL, N=2", [*first, *d[:2]]
    return "POLYNOMIAL, N=3", [*first, law.c30, 0.0, 0.0, 0.0, *d]
