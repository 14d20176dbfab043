"""Every example runs, and gives the number that its reader is told."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
EXPECTED = {
    "ex01_press": pytest.approx(0.1997, rel=0.01),
    "ex02_markers": pytest.approx(1.949, rel=0.01),
    "ex03_two_states": pytest.approx(2.29, abs=0.1),
    "ex04_mesh": pytest.approx(-0.0122, abs=0.003),
    "ex05_mold": pytest.approx(9.17, rel=0.01),
}


def test_every_example_is_expected() -> None:
    assert sorted(path.stem for path in EXAMPLES.glob("ex*.py")) == sorted(EXPECTED)


@pytest.mark.parametrize("name", EXPECTED)
def test_an_example_gives_its_number(name: str, capsys) -> None:
    if name == "ex05_mold":
        pytest.importorskip("build123d")
    value = runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"]()
    assert value == EXPECTED[name]
    assert capsys.readouterr().out
