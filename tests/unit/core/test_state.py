"""States: entries by name only, and arrays in the order of names."""

import numpy as np
import pytest

from palpate.core.state import State

CONTACT = State(("depth_mm", "inverse_friction", "curvature"), np.array([2.0, 0.5, -1.0]))


def test_entries_have_names() -> None:
    assert CONTACT["inverse_friction"] == 0.5
    assert CONTACT["curvature", "depth_mm"].tolist() == [-1.0, 2.0]
    assert CONTACT.to_array(["curvature"]).tolist() == [-1.0]
    with pytest.raises(KeyError):
        CONTACT["twist"]


@pytest.mark.parametrize("place", [0, -1, slice(2), (0, 1), np.int64(1), None])
def test_a_place_that_is_no_name_is_refused(place: object) -> None:
    with pytest.raises(TypeError):
        CONTACT[place]  # type: ignore[call-overload]


def test_a_changed_state_is_another() -> None:
    other = CONTACT.replace(depth_mm=3.0).add(("curvature", "inverse_friction"), np.array([1.0, 0.25]))
    assert other.values.tolist() == [3.0, 0.75, 0.0]
    assert CONTACT.values.tolist() == [2.0, 0.5, -1.0]
    assert (other - CONTACT).values.tolist() == [1.0, 0.25, 1.0]
    assert (other + State(CONTACT.names[::-1], np.array([1.0, 2.0, 3.0]))).values.tolist() == [6.0, 2.75, 1.0]


def test_rows_of_derivatives_have_the_names_of_their_columns() -> None:
    jacobian = State(("a", "b"), np.arange(12.0).reshape(3, 2, 2))
    assert jacobian["b"].tolist() == [[1.0, 3.0], [5.0, 7.0], [9.0, 11.0]]
    assert jacobian["b", "a"].shape == (3, 2, 2)


def test_names_and_values_belong_together() -> None:
    with pytest.raises(TypeError):
        State(("a",), np.zeros(2))


def test_states_are_made_of_mappings_and_of_zeros_and_know_their_length() -> None:
    made = State.from_mapping({"b": 2.0, "a": 1})
    assert (made.names, made.values.tolist(), len(made)) == (("b", "a"), [2.0, 1.0], 2)
    assert State.zeros(("x", "y", "z")).values.tolist() == [0.0, 0.0, 0.0]
    for names in (("a", "none"), ("none",)):
        with pytest.raises(KeyError):
            made.to_array(names)
    with pytest.raises(TypeError):
        made.to_array((0,))  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        State(("a",), np.array([1.0, 2.0]))
