import pytest

from errors import refused
from palpate.core import Spec, flag_name, parameter, parameters


class HoleSpec(Spec):
    """A bored hole."""

    diameter: float = parameter(6.0, unit="mm", meaning="bore", source="catalogue", gt=0, le=20)
    offsets: tuple[float, ...] = parameter((), unit="mm", meaning="offsets of the holes")
    name: str = "hole"


def test_a_number_with_its_unit_is_read() -> None:
    assert HoleSpec(diameter="8 mm").diameter == 8.0  # type: ignore[arg-type]
    assert HoleSpec(offsets=["1 mm", 2]).offsets == (1.0, 2.0)  # type: ignore[arg-type]


@pytest.mark.parametrize("text", ["0.8", "8e-1", ".8", " 0.8 mm"])
def test_a_number_as_text_is_no_number_with_a_unit(text: str) -> None:
    assert HoleSpec(diameter=text).diameter == 0.8  # type: ignore[arg-type]


def test_another_unit_is_refused_by_name() -> None:
    with refused("quantity-unit-wrong", "diameter", "cm", "mm"):
        HoleSpec(diameter="8 cm")  # type: ignore[arg-type]


@pytest.mark.parametrize(("diameter", "code"), [(0.0, "greater_than"), (20.5, "less_than_equal")])
def test_bounds_hold(diameter: float, code: str) -> None:
    with refused(code, "diameter", diameter):
        HoleSpec(diameter=diameter)


def test_unknown_keys_are_refused() -> None:
    with refused("extra_forbidden"):
        HoleSpec(radius=3.0)  # type: ignore[call-arg]


def test_notes_repeat_what_the_field_declares() -> None:
    bore, offsets, name = parameters(HoleSpec)
    assert (bore.name, bore.unit, bore.default) == ("diameter", "mm", 6.0)
    assert (bore.bounds, bore.source) == ("> 0, <= 20", "catalogue")
    assert (bore.meaning, bore.help) == ("bore", "Bore (mm; > 0, <= 20).")
    assert offsets.default == ()
    assert (name.unit, name.help) == ("", "")


@pytest.mark.parametrize("diameter", [float("nan"), float("inf"), "nan", "-inf"])
def test_a_number_that_is_not_finite_is_refused(diameter: float | str) -> None:
    with refused("finite_number"):
        HoleSpec(diameter=diameter)  # type: ignore[arg-type]
    with refused("finite_number"):
        HoleSpec(offsets=(diameter,))  # type: ignore[arg-type]


class DrillSpec(Spec):
    """A drill."""

    point_deg: float = parameter(118.0, unit="deg", meaning="angle of the point")
    shank_length: float = parameter(30.0, unit="mm", meaning="length of the shank")
    diameter: float = parameter(6.0, unit="mm", meaning="diameter", flag="drill")


def test_a_flag_is_declared_at_the_field_or_its_name_without_the_unit() -> None:
    assert [flag_name(DrillSpec, name) for name in DrillSpec.model_fields] == ["point", "shank-length", "drill"]


def test_a_text_that_begins_with_a_number_is_no_quantity() -> None:
    class NameSpec(Spec):
        name: str = parameter("a", unit="", meaning="name")

    assert NameSpec.model_validate({"name": "1st"}).name == "1st"
