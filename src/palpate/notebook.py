"""Formatters that draw results in a notebook; `enable` registers them."""

from __future__ import annotations

import importlib
from typing import Any

from palpate.core import PalpateError
from palpate.fea import Press, tabulate_press
from palpate.study import SpecificationGrid, html_rows


def enable() -> None:
    """Let IPython show a press and a grid as tables.

    Raises
    ------
    PalpateError
        Outside IPython.
    """
    try:
        shell: Any = importlib.import_module("IPython").get_ipython()
    except ImportError:
        shell = None
    if shell is None:
        raise PalpateError(
            "This is no notebook.", "Call palpate.notebook.enable() in IPython or Jupyter.", code="notebook-missing"
        )
    register(shell.display_formatter.formatters["text/html"])


def register(formatter: Any) -> None:
    """Give an HTML formatter of IPython the tables of presses and grids."""
    formatter.for_type(Press, tabulate_press)
    formatter.for_type(SpecificationGrid, html_rows)
