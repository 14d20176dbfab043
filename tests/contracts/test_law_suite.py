"""Every law of the package, one row each and one for each of its models."""

import pytest

from palpate.material import LAWS, Law, get_material, list_models
from palpate.testing import LawSuite

LAW_OF = {
    "neo-hooke": "neo-hooke:0.0141",
    "mooney-rivlin": "mooney-rivlin:0.1,0.05",
    "mooney-rivlin-3": "mooney-rivlin:0.1,0.05,0.01",
    "mooney-rivlin-5": "mooney-rivlin:0.1,0.05,0.01,-0.004,0.003",
    "yeoh": "zaid_2024_ecoflex_00_30",
    "unstable yeoh": "yeoh:0.1,-0.01,0.001",
    "gent": "gent:0.03,80",
    "ogden-1": "ogden:0.02,2.7",
    "ogden-2": "ogden:0.02,2.5,-0.004,-1.5",
    "ogden-3": "ogden:0.63,1.3,0.0012,5,-0.01,-2",
    "arruda-boyce": "arruda-boyce:0.028,3",
    "polynomial": "polynomial:0.1,0.05,0.01,-0.004,0.003,0.0005",
}


def test_every_law_and_every_model_has_a_row() -> None:
    assert {*LAWS.names, *list_models()} <= {*LAW_OF, *(get_material(text).law.name for text in LAW_OF.values())}


class TestLaw(LawSuite):
    @pytest.fixture(params=LAW_OF)
    def law(self, request: pytest.FixtureRequest) -> Law:
        return get_material(LAW_OF[request.param]).law
