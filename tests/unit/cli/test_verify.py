import json

import pytest

from errors import check_refusal, check_values
from palpate.cli import main
from palpate.verify import Case
from palpate.verify.case import compare


def call(*words: str) -> int:
    with pytest.raises(SystemExit) as left:
        main(words)
    assert isinstance(left.value.code, int)
    return left.value.code


def test_verify_prints_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("verify", "--only", "yeoh") == 0
    shown = capsys.readouterr()
    assert "yeoh_drucker_limits" in shown.out
    check_values(shown.out, 24)
    check_values(shown.err, "yeoh_homogeneous")


def test_verify_speaks_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("verify", "--only", "zero_energy_modes", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["passed"]
    assert shown["cases"][0]["rows"][0]["ours"] == 6


def test_a_row_outside_its_tolerance_is_exit_code_1(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    bad = Case("bad", "exact", lambda: [compare("force, N", 1.1, 1.0, 0.01)])
    monkeypatch.setattr("palpate.verify.choose_cases", lambda only: (bad,))
    assert call("verify") == 1
    check_values(capsys.readouterr().out, "bad", 0, 1)


def test_an_unknown_case_is_refused_with_the_names(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("verify", "--only", "doom") == 2
    check_refusal(capsys.readouterr().err, "case-unknown", "doom", "press_derivatives")
