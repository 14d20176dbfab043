"""Columns of a table by the quantity that they hold: angles, lengths and forces of named axes."""

from __future__ import annotations

from palpate.core import PalpateError
from palpate.core.units import split_unit
from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.pose_column import AXES, PoseColumn, name_axes, short_name, with_unit
from palpate.datasets.recording_columns import list_columns
from palpate.datasets.table import RecordingTable


def find_angles_and_lengths(
    table: RecordingTable, choice: ColumnMapping, taken: tuple[str, ...], doubts: list[PalpateError] | None = None
) -> dict[str, PoseColumn]:
    """Columns of numbers by axis, constant ones included; of two of one axis the first.

    Errors of columns whose unit is unknown are appended to `doubts`.
    """
    found = []
    for name in table.columns:
        if name in taken or not table.is_numeric(name):
            continue
        try:
            found.append(with_unit(table, name, choice))
        except PalpateError as error:
            if doubts is not None:
                doubts.append(error)
    return {one.axis: one for one in reversed(name_axes(found))}


def find_quantities(
    table: RecordingTable,
    choice: ColumnMapping,
    taken: tuple[str, ...],
    axes: tuple[str, ...],
    optional: tuple[str, ...] = (),
) -> dict[str, PoseColumn]:
    """Columns of named axes, in deg, mm and N, with NaN in empty cells.

    Parameters
    ----------
    table, choice
        The table, and the statements of the user on it.
    taken
        Columns that are something else.
    axes, optional
        Axes that must exist, and that may.

    Raises
    ------
    PalpateError
        If one is missing, its unit is unknown, or a cell is no number; the message names the line.
    """
    doubts: list[PalpateError] = []
    named = find_angles_and_lengths(table, choice, taken, doubts)
    missing = [axis for axis in axes if axis not in named]
    texts = [name for name in table.columns if name not in taken and not table.is_numeric(name)]
    for name in texts:
        bare = AXES.get(short_name(split_unit(name.lower())[0]), short_name(split_unit(name.lower())[0]))
        if bare in missing:
            raise PalpateError(
                f"{table.name}, line {table.first_line}: {name} is '{table.columns[name][0]}', no number.",
                "Write numbers.",
                code="value-not-number",
            )
    if missing and doubts:
        raise doubts[0]
    if missing:
        raise PalpateError(
            f"{table.name} has no column for {', '.join(missing)}; it has {list_columns(table)}.",
            f"Name columns {', '.join(axes)}, with a unit: rx_deg, depth_mm.",
            code="column-missing",
        )
    chosen = {axis: named[axis] for axis in (*axes, *optional) if axis in named}
    for axis in chosen:
        fault = table.faults.get(named[axis].column)
        if fault:
            raise PalpateError(
                f"{table.name}, column {named[axis].column}: {fault}.", "Write a number.", code="value-not-number"
            )
    return chosen
