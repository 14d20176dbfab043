"""Principal components are the same whatever signs a linear algebra library gives them."""

import numpy as np
import pytest

from palpate.learn.components import find_components


def inputs(symmetric: bool) -> np.ndarray:
    rng = np.random.default_rng(4)
    found = rng.normal(size=(300, 6)) * [5.0, 4.0, 3.0, 2.0, 1.0, 0.5]
    mix = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    if symmetric:  # two entries of a direction are as great
        mix = np.kron(np.array([[1.0, 1.0], [1.0, -1.0]]) / 2**0.5, np.eye(3))
    return found @ mix.T


@pytest.mark.parametrize("symmetric", [False, True])
def test_signs_do_not_depend_on_the_library(symmetric: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    eigh, given = np.linalg.eigh, inputs(symmetric)
    mean, covariance = given.mean(axis=0), np.cov(given, rowvar=False)

    def project():
        return find_components(mean, covariance, 6, np.sqrt).projection

    found = [project()]
    for seed in range(4):
        signs = np.random.default_rng(seed).choice([-1.0, 1.0], 6)
        noise = 1.0 + 1e-13 * np.random.default_rng(seed).normal(size=(6, 6))

        def other(matrix, signs=signs, noise=noise):
            values, directions = eigh(matrix)
            return values, directions * signs * noise

        monkeypatch.setattr(np.linalg, "eigh", other)
        found.append(project())
        monkeypatch.setattr(np.linalg, "eigh", eigh)
    assert all(each == pytest.approx(found[0], rel=1e-9, abs=1e-12) for each in found[1:])
    if not symmetric:
        assert (np.take_along_axis(found[0], np.abs(found[0]).argmax(axis=0)[None], 0) > 0).all()
