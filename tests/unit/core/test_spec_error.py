"""Wrong values of a spec: one sentence for each, with the value, the bounds and the unit."""

import pickle
from typing import Literal

import numpy as np
import pytest
from pydantic import ValidationError

from errors import check_values
from palpate.core import PalpateError, Spec, parameter


class HoleSpec(Spec):
    diameter: float = parameter(6.0, unit="mm", meaning="bore", gt=0, le=20)
    kind: Literal["round", "square"] = "round"


class PlateSpec(Spec):
    hole: HoleSpec = HoleSpec()


def test_a_wrong_value_is_an_error_of_palpate_and_of_pydantic():
    with pytest.raises(PalpateError) as caught:
        HoleSpec(diameter=-1)
    error = caught.value
    assert isinstance(error, ValidationError)
    assert error.code == error.errors()[0]["type"] == "greater_than"
    assert error.problem == "HoleSpec.diameter is -1; it must be greater than 0."
    assert error.remedy == "Give the bore (mm; > 0, <= 20)."
    assert str(error) == f"{error.problem} {error.remedy}"
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.code, again.errors()[0]["loc"]) == (str(error), error.code, ("diameter",))


def test_each_wrong_value_has_a_sentence_without_a_link():
    with pytest.raises(PalpateError) as caught:
        HoleSpec(diameter="6 inch", kind="oval")
    assert "HoleSpec.kind: unknown value 'oval'; choose round or square." in caught.value.problem
    assert "but its unit is mm" in caught.value.problem
    assert "http" not in str(caught.value)


def test_values_inside_a_spec_name_their_place():
    with pytest.raises(PalpateError) as caught:
        PlateSpec(hole={"diameter": np.float32(30)})
    check_values(caught.value.problem, "PlateSpec.hole.diameter", 30.0, 20)
    with pytest.raises(PalpateError) as caught:
        PlateSpec(hole={"diameter": lambda: 30})
    assert pickle.loads(pickle.dumps(caught.value)).problem == caught.value.problem
    with pytest.raises(PalpateError) as caught:
        PlateSpec(hole={"diameter": 30})
    check_values(caught.value.problem, "PlateSpec.hole.diameter", 30, 20)
