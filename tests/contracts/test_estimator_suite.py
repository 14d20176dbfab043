"""Every kind of estimator of the package."""

from functools import partial

import pytest

from needs import needs
from palpate.learn import ESTIMATORS, EnsembleMember
from palpate.testing import EstimatorSuite


class TestEstimator(EstimatorSuite):
    @pytest.fixture(params=ESTIMATORS.names)
    def kind(self, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> type[EnsembleMember]:
        found = ESTIMATORS.get(request.param)
        if found.effort != "ridge":
            needs("torch")
            needs("onnxruntime")
            from palpate.learn import train_member

            # a network on markers has 300 epochs of its own, whatever is asked for
            brief = partial(train_member.train_marker_network, epochs=40)
            monkeypatch.setattr(train_member, "train_marker_network", brief)
        return found
