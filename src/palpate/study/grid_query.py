"""Queries of a grid: ``max_error_deg < 2 and height_mm <= 20``.

A query is parsed by Python's parser and evaluated here. Only column names, numbers, texts, comparisons (also
chained), ``and``, ``or`` and ``not`` are accepted; everything else is rejected, so that a query cannot execute code.
A comparison with an empty cell is false.
"""

from __future__ import annotations

import ast
import difflib
import operator
from collections.abc import Callable, Sequence
from typing import Any

from palpate.core import PalpateError, new_column
from palpate.study.grid import Cell, Row, own_column

LONGEST = 1000
"""Maximum number of characters of a query."""

_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}


def filter_rows(rows: Sequence[Row], where: str) -> tuple[Row, ...]:
    """Return the rows for which a query is true.

    Parameters
    ----------
    rows
        Rows of a grid, all with the same columns.
    where
        The query.

    Raises
    ------
    PalpateError
        If the query is invalid, names an unknown column, or compares a text with a number.

    Examples
    --------
    >>> filter_rows([{"markers": 7}, {"markers": 91}], "markers >= 37")
    ({'markers': 91},)
    """
    question = _parse(where)
    for node in ast.walk(question):
        if isinstance(node, ast.Name) and rows:
            node.id = new_column(node.id, rows[0])
            check_column(node.id, rows[0])
    return tuple(row for row in rows if _holds(question, row))


def sort_rows(rows: Sequence[Row], by: str) -> tuple[Row, ...]:
    """Sort rows by one column, ascending. Rows without a figure come last.

    Parameters
    ----------
    rows
        Rows of a grid, all with the same columns.
    by
        Name of a column. A leading minus, or the word ``desc`` after the name, reverses; ``asc`` changes nothing.
        Rows of an obstacle without a tilt are sorted by the offset's column instead of the angle's.

    Raises
    ------
    PalpateError
        If there is no such column.
    """
    column, reverse = _parse_order(by)
    if rows:
        column = own_column(rows[0], new_column(column, rows[0]))
        check_column(column, rows[0])
    known = [row for row in rows if row[column] is not None]
    known.sort(key=lambda row: row[column], reverse=reverse)  # type: ignore[arg-type,return-value]
    return (*known, *(row for row in rows if row[column] is None))


def _parse_order(by: str) -> tuple[str, bool]:
    """Return the name of the column, and whether to sort in descending order."""
    words = by.split()
    if len(words) == 2 and words[1].lower() in ("asc", "desc") and not by.lstrip().startswith("-"):
        return words[0], words[1].lower() == "desc"
    return by.strip().removeprefix("-"), by.strip().startswith("-")


def check_column(name: str, row: Row) -> None:
    """Reject the name of a column that `row` lacks, naming the nearest."""
    if name in row:
        return
    nearest = difflib.get_close_matches(name, list(row), n=1, cutoff=0.0)
    raise PalpateError(
        f"The grid has no column '{name}'.", f"Did you mean '{nearest[0]}'?" if nearest else "", code="column-unknown"
    )


def _parse(where: str) -> ast.expr:
    if len(where) > LONGEST:
        raise PalpateError(
            f"The question has {len(where)} characters.",
            f"Ask in {LONGEST} characters or fewer.",
            code="question-too-long",
        )
    try:
        return ast.parse(where.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else "it cannot be read"
        raise PalpateError(
            f"The question '{where}' is not understood: {reason}.", _EXAMPLE, code="question-malformed"
        ) from None


_EXAMPLE = "Write for example: max_error_deg < 2 and height_mm <= 20"


def _holds(node: ast.expr, row: Row) -> bool:
    """Evaluate a logical part of the query for a row."""
    if isinstance(node, ast.BoolOp):
        parts = (_holds(part, row) for part in node.values)
        return all(parts) if isinstance(node.op, ast.And) else any(parts)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return not _holds(node.operand, row)
    if isinstance(node, ast.Compare):
        cells = [_cell(part, row) for part in (node.left, *node.comparators)]
        pairs = zip(cells, node.ops, cells[1:], strict=False)
        return all(_compares(left, comparison, right) for left, comparison, right in pairs)
    raise PalpateError(f"'{ast.unparse(node)}' is neither true nor false.", _EXAMPLE, code="question-not-condition")


def _cell(node: ast.expr, row: Row) -> Cell:
    """Evaluate a name, a number or a text."""
    if isinstance(node, ast.Name):
        return row[node.id]
    if isinstance(node, ast.Constant) and type(node.value) in (int, float, str):
        value: Cell = node.value  # type: ignore[assignment]
        return value
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant):
        value = _cell(node.operand, row)
        if isinstance(value, int | float):
            return -value
    raise PalpateError(
        f"'{ast.unparse(node)}' is neither a column, a number nor a text in quotes.",
        _EXAMPLE,
        code="question-operand-unknown",
    )


def _compares(left: Cell, comparison: ast.cmpop, right: Cell) -> bool:
    compare = _COMPARISONS.get(type(comparison))
    if compare is None:
        raise PalpateError("Only <, <=, >, >=, == and != compare.", _EXAMPLE, code="question-operator-unknown")
    if left is None or right is None:
        return False
    if isinstance(left, str) != isinstance(right, str):
        raise PalpateError(
            f"'{left}' and '{right}' cannot be compared.",
            "Put texts in quotes, numbers not.",
            code="question-types-differ",
        )
    return compare(left, right)
