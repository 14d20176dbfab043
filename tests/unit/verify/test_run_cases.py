from errors import refused
from palpate.core import PalpateError
from palpate.verify import CASES, Case, CaseOutcome, choose_cases, outcome_report, run_cases
from palpate.verify.case import compare
from palpate.verify.read_reference import read_reference


def fails() -> list:
    raise PalpateError("No equilibrium was found.", "Refine the mesh.", code="equilibrium-not-found")


GOOD = Case("good", "exact", lambda: [compare("force, N", 1.0, 1.0, 0.01)])
BAD = Case("bad", "exact", lambda: [compare("force, N", 1.1, 1.0, 0.01, ["d = 1 mm"])])
LOST = Case("lost", "exact", fails)


def test_names_are_unique() -> None:
    assert len({case.name for case in CASES}) == len(CASES)


def test_a_pattern_chooses_cases() -> None:
    assert {case.name for case in choose_cases("table_")} == {"table_2_recovery"}
    assert [case.name for case in choose_cases("yeoh_?imple")] == ["yeoh_simple_shear"]
    assert choose_cases() == CASES


def test_a_pattern_that_names_nothing_is_refused_with_the_names() -> None:
    with refused("case-unknown", "doom") as caught:
        choose_cases("doom")
    assert "press_derivatives" in caught.value.remedy


def test_a_case_that_cannot_be_solved_is_an_outcome() -> None:
    outcomes = list(run_cases([GOOD, BAD, LOST]))
    assert [outcome.passed for outcome in outcomes] == [True, False, False]
    assert outcomes[2].failure


def test_the_table_has_every_row_and_the_reason_of_a_failure() -> None:
    rows = outcome_report([*run_cases([GOOD, BAD, LOST])]).rows
    assert [row["case"] for row in rows] == ["good", "bad", "lost"]
    assert list(rows[1].values()) == [
        "bad",
        "exact",
        "force, N at d = 1 mm",
        1,
        "1.1",
        "1",
        "10.00 %",
        "1.00 %",
        "NO",
    ]


def test_references_are_part_of_the_package() -> None:
    data = read_reference("sphere_inflation_Ri18_Ro20").where(material="neo")
    assert len(data.labels("material")) == len(data) > 0


def test_an_outcome_without_rows_has_failed_only_with_a_reason() -> None:
    assert CaseOutcome(GOOD, (), 0.0).passed
    assert not CaseOutcome(GOOD, (), 0.0, "lost").passed
