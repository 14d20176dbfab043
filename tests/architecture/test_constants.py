"""Constants: each has a sentence; numbers of constants and literals may only fall.

"By hand." in a sentence means that nothing derived or measured set the value. Its effect is a row of
`docs/results/constants.csv` (quick tests that fail at half and at twice the value) or `press_constants.csv` (change
of force). Without a row, the effect has not been measured.
"""

import ast
import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from source_files import FILES, SOURCE, name, nodes, tree

RESULTS = [Path(__file__).parents[2] / "docs" / "results" / one for one in ("constants.csv", "press_constants.csv")]
BY_HAND = "By hand."
MOST_CONSTANTS, MOST_LITERALS = 1071, 2638
MOST_BY_HAND, MOST_UNMEASURED = 648, 347
WITHOUT_SENTENCE = {"viewer": 11, "fabrication": 13}
"""Numbers that may only fall: constants, literals other than `PLAIN`; constants by hand, and without a sentence."""
PLAIN = {0, 1, 2, 0.5}
Container = ast.Tuple | ast.List | ast.Set | ast.Dict
Function = ast.FunctionDef | ast.AsyncFunctionDef


class Constant(NamedTuple):
    """Names that one statement assigns, in a file, and the sentence below it."""

    path: str
    names: tuple[str, ...]
    sentence: str


def is_number(node: ast.expr) -> bool:
    """Whether an expression is a number, or contains one that is not a position."""
    if isinstance(node, ast.Constant):
        return type(node.value) in (int, float, complex)
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.BinOp):
        return is_number(node.left) or is_number(node.right)
    if isinstance(node, ast.Dict):
        return any(map(is_number, node.values))
    return isinstance(node, Container) and any(map(is_number, node.elts))


def constants(path: Path) -> Iterator[Constant]:
    """Numeric constants at the module level of a file."""
    body = tree(path).body
    for node, after in zip(body, [*body[1:], ast.Pass()], strict=True):
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and is_number(node.value):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = tuple(one.id for target in targets for one in ast.walk(target) if isinstance(one, ast.Name))
            documented = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            yield Constant(name(path), names, str(after.value.value) if documented else "")


def all_constants() -> list[Constant]:
    """Numeric constants of the package."""
    return [one for path in FILES if path.is_relative_to(SOURCE) for one in constants(path)]


def literals() -> int:
    """Numbers in the bodies of functions, other than 0, ±1, 2 and ½."""
    functions = (node for path in FILES if path.is_relative_to(SOURCE) for node in nodes(path))
    bodies = (item for node in functions if isinstance(node, Function) for item in node.body)
    numbers = {id(one): one for item in bodies for one in ast.walk(item) if isinstance(one, ast.Constant)}
    return sum(type(one.value) in (int, float) and one.value not in PLAIN for one in numbers.values())


def test_each_constant_has_a_sentence() -> None:
    silent = [one for one in all_constants() if not one.sentence]
    for subpackage, most in WITHOUT_SENTENCE.items():
        assert sum(len(one.names) for one in silent if one.path.startswith(subpackage + "/")) <= most, subpackage
    assert [one for one in silent if one.path.split("/")[0] not in WITHOUT_SENTENCE] == []


def test_the_numbers_of_constants_and_literals_do_not_rise() -> None:
    assert sum(len(one.names) for one in all_constants()) <= MOST_CONSTANTS
    assert literals() <= MOST_LITERALS


def rows() -> list[dict[str, str]]:
    """Measured effects of constants."""
    return [row for path in RESULTS for row in csv.DictReader(path.read_text("utf-8").splitlines())]


def test_each_row_of_effects_is_of_a_constant() -> None:
    known = {(one.path, name) for one in all_constants() for name in one.names}
    assert {(row["file"], row["constant"]) for row in rows()} <= known


def test_few_values_chosen_by_hand_are_without_a_measured_effect() -> None:
    measured = {(row["file"], row["constant"]) for row in rows()}
    by_hand = {
        (one.path, name) for one in all_constants() if one.sentence.rstrip().endswith(BY_HAND) for name in one.names
    }
    assert len(by_hand) <= MOST_BY_HAND
    assert len(by_hand - measured) <= MOST_UNMEASURED
