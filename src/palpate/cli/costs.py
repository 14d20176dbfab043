"""Costs of the commands: measured CPU-seconds, printed below the help of each."""

import csv
from functools import cache
from pathlib import Path


@cache
def _costs() -> dict[str, str]:
    with Path(__file__).with_name("costs.csv").open(newline="", encoding="utf-8") as file:
        return {row["verb"]: f"Cost: {row['cpu_s']} CPU-s for `{row['command']}`." for row in csv.DictReader(file)}


def cost_sentence(verb: str) -> str | None:
    """Return the cost of a command as `benchmarks/command_costs.py` measured it, or `None`.

    Parameters
    ----------
    verb
        Words of the command after `palpate`.
    """
    return _costs().get(verb)
