"""Every kind of estimator of the package."""

import pytest

from needs import needs
from palpate.learn import ESTIMATORS, EnsembleMember
from palpate.testing import EstimatorSuite


class TestEstimator(EstimatorSuite):
    @pytest.fixture(params=ESTIMATORS.names)
    def kind(self, request: pytest.FixtureRequest) -> type[EnsembleMember]:
        found = ESTIMATORS.get(request.param)
        if found.effort != "ridge":
            needs("torch")
            needs("onnxruntime")
        return found
