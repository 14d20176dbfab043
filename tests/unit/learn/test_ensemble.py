"""Weighted means of estimators, in closed form."""

import numpy as np
import pytest

from palpate.learn.ensemble import MIXTURE, PICTURES, select_ensemble


def estimates(count: int) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Poses of two axes, and two estimates with errors n and -n/2: (1 a + 2 b) / 3 has none."""
    rng = np.random.default_rng(0)
    poses, noise = rng.normal(size=(count, 2)), rng.normal(size=(count, 2))
    return {"a": poses + noise, "b": poses - noise / 2}, poses


def test_two_parts_with_opposite_errors_get_the_weights_that_cancel_them() -> None:
    found, poses = estimates(40)
    ranked, best, pictures = select_ensemble(found, poses, np.ones(40, bool), np.ones(2), {"b"})
    assert [option.name for option in ranked] == [MIXTURE, "b", "a"]
    assert best is ranked[0]
    assert best.parts == ("a", "b")
    assert best.weights == pytest.approx(np.array([[1 / 3, 1 / 3], [2 / 3, 2 / 3]]), abs=1e-3)
    assert best.error == pytest.approx(0.0, abs=1e-3)
    assert pictures is not None
    assert pictures.name == "a"
    assert PICTURES not in {option.name for option in ranked}


@pytest.mark.parametrize(("count", "mixed"), [(29, False), (30, True)])
def test_thirty_images_are_needed_for_a_mixture(count: int, mixed: bool) -> None:
    found, poses = estimates(40)
    _, best, _ = select_ensemble(found, poses, np.arange(40) < count, np.ones(2), set())
    assert best is not None
    assert (best.name == MIXTURE) == mixed


def test_a_part_that_adds_nothing_has_no_weight() -> None:
    """An estimate with the same error twice is left out; one part is no mixture."""
    found, poses = estimates(40)
    _, best, _ = select_ensemble(
        {"a": found["a"], "worse": 2.0 * found["a"] - poses}, poses, np.ones(40, bool), np.ones(2), set()
    )
    assert best is not None
    assert best.parts == ("a",)
