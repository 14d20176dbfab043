"""Laws and models by name: those of palpate, and those of packages in the group ``palpate.laws``."""

from __future__ import annotations

from palpate.core import PalpateError, Registry
from palpate.material.law import Law, Model
from palpate.material.laws.polynomial import Polynomial
from palpate.material.model import LinearModel

_HERE = "palpate.material.laws"

LAWS: Registry[type[Law]] = Registry(
    "palpate.laws",
    "law",
    {
        "neo-hooke": f"{_HERE}.neo_hooke:NeoHooke",
        "mooney-rivlin": f"{_HERE}.mooney_rivlin:MooneyRivlin",
        "yeoh": f"{_HERE}.yeoh:Yeoh",
        "gent": f"{_HERE}.gent:Gent",
        "ogden": f"{_HERE}.ogden:Ogden",
        "arruda-boyce": f"{_HERE}.arruda_boyce:ArrudaBoyce",
        "polynomial": f"{_HERE}.polynomial:Polynomial",
    },
    fits=lambda found: isinstance(found, type) and issubclass(found, Law),
)
"""Laws by name."""

SECOND_INVARIANT = LinearModel("yeoh-i2", Polynomial, ("C10", "C01", "C20", "C30"))
"""Yeoh's law with a term in I2: not selectable, shows the effect of I2 in unmeasured modes."""


def list_models() -> tuple[str, ...]:
    """Names of the models by which curves are fitted, those of other packages last."""
    return tuple(_models())


def get_model(name: str) -> Model:
    """Get a model by its name.

    Raises
    ------
    PalpateError
        If there is no such model.
    """
    models = _models() | {SECOND_INVARIANT.name: SECOND_INVARIANT}
    if name not in models:
        raise PalpateError(
            f"There is no model '{name}'.", f"Choose one of {', '.join(list_models())}.", code="law-unknown"
        )
    return models[name]


def _models() -> dict[str, Model]:
    return {model.name: model for _, law in LAWS.available() for model in law.models()}
