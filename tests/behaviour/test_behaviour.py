"""A stage that returns other results needs a new stamp: `python tests/behaviour/results.py STAGE` writes it."""

import json

import pytest

from behaviour.cases import CASES
from behaviour.results import compare, compute
from palpate.core.behaviour import BEHAVIOUR_FILE


@pytest.mark.parametrize("stage", CASES)
def test_results_of_a_stage_are_those_of_its_stamp(stage: str) -> None:
    faults = compare(stage, json.loads(BEHAVIOUR_FILE.read_text())[stage], compute(stage))
    assert not faults, "\n".join(faults)
