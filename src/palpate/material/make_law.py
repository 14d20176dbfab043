"""From a law's name and constants to the law."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from palpate.core import PalpateError
from palpate.material.law import MOONEY_RIVLIN, Law, Polynomial, mooney_rivlin, neo_hooke, ogden, yeoh
from palpate.material.locking import arruda_boyce, gent


@dataclass(frozen=True)
class _Form:
    """How a law is written: the function, the names of its constants by their count, and a person's reminder."""

    make: Callable[..., Law]
    names: dict[int, tuple[str, ...]]
    written: str


def _upper(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(name.upper() for name in names)


def _ogden_names(terms: int) -> tuple[str, ...]:
    return tuple(name for k in range(1, terms + 1) for name in (f"mu{k}", f"alpha{k}"))


FORMS: dict[str, _Form] = {
    "yeoh": _Form(yeoh, {3: ("C10", "C20", "C30")}, "C10,C20,C30"),
    "neo-hooke": _Form(neo_hooke, {1: ("C10",)}, "C10"),
    "mooney-rivlin": _Form(
        mooney_rivlin,
        {count: _upper(names) for count, names in MOONEY_RIVLIN.items()},
        "C10,C01 or C10,C01,C11 or C10,C01,C20,C11,C02",
    ),
    "ogden": _Form(
        ogden, {2 * terms: _ogden_names(terms) for terms in (1, 2, 3)}, "mu1,alpha1[,mu2,alpha2[,mu3,alpha3]]"
    ),
    "gent": _Form(gent, {2: ("mu", "Jm")}, "mu,Jm"),
    "arruda-boyce": _Form(arruda_boyce, {2: ("mu", "lm")}, "mu,lm"),
}
"""Laws by name."""


def law_from_numbers(name: str, numbers: Sequence[float]) -> Law:
    """Make a law from its constants in the order in which they are written, MPa (exponents: pure numbers).

    Raises
    ------
    PalpateError
        If there is no such law, or it takes another count of constants.
    """
    form = _form(name)
    if len(numbers) not in form.names:
        raise PalpateError(
            f"{name} takes {form.written}, but {len(numbers)} numbers were given.", "Write them in MPa."
        )
    return form.make(*numbers)


def law_from_constants(name: str, constants: Mapping[str, float]) -> Law:
    """Make a law from its constants by name, as `Law.constants` gives them; coefficients left out are zero.

    Raises
    ------
    PalpateError
        If there is no such law, or its constants have other names.
    """
    form = _form(name)
    if form.make in (yeoh, neo_hooke, mooney_rivlin):
        known = {name for names in form.names.values() for name in names}
        if constants and set(constants) <= known:
            return Polynomial(name, **{"c10": 0.0} | {key.lower(): value for key, value in constants.items()})
    names = form.names.get(len(constants), ())
    if set(names) != set(constants) or not names:
        raise PalpateError(
            f"The constants of {name} are not {', '.join(constants) or 'none'}.", f"They are {form.written}."
        )
    return form.make(*(constants[key] for key in names))


def _form(name: str) -> _Form:
    if name not in FORMS:
        raise PalpateError(f"There is no law '{name}'.", f"Choose one of {', '.join(FORMS)}.")
    return FORMS[name]
