"""The proof: how far what was played is from what was foreseen, and in which order."""

import pytest

from palpate.built import BuiltFigure
from palpate.optimise import BenchFigure, Proof, ProvenDesign, SecondSolver
from palpate.optimise.proof import proof_lines


def design(title: str, foreseen: tuple[float, float], played: tuple[float, float]) -> ProvenDesign:
    told = BuiltFigure(5, *foreseen, depth_rmse=0.01, noise_deg=0.01)
    return ProvenDesign(title, "H20 T2", 91, 48.0, 0.6, told, BenchFigure(20, 2160, 0, *played, depth_rmse=0.01))


def test_the_figure_that_is_farthest_off_counts() -> None:
    assert design("winner", (0.02, 0.08), (0.021, 0.1)).off == pytest.approx(0.25)


def test_the_order_is_the_same_only_where_both_figures_say_so() -> None:
    winner, rival = design("winner", (0.02, 0.08), (0.021, 0.09)), design("rival", (0.026, 0.1), (0.027, 0.11))
    outlier = design("winner", (0.02, 0.08), (0.021, 0.15))
    assert Proof((winner, rival), known=5).same_order
    assert not Proof((outlier, rival), known=5).same_order
    assert "is not the same" in "\n".join(proof_lines(Proof((outlier, rival), known=5)))


def test_a_page_says_from_which_depth_the_solvers_part() -> None:
    second = SecondSolver(4.8, 0.177, 0.182, 0.043, parts_mm=5.6)
    page = "\n".join(proof_lines(Proof((design("winner", (0.02, 0.08), (0.02, 0.08)),), 5, second)))
    assert "From 5.6 mm on one of them shows the inverted state" in page
    assert "+2.8 %" in page
