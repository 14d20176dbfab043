"""Which columns of a bench's table are strain and stress, and in which unit."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from palpate.core import PalpateError
from palpate.material.spec import StrainUnit, StressUnit, TestFileSpec
from palpate.material.table import Table

_STRAIN = re.compile(r"strain|stretch|lambda|λ|dehnung|stauchung|elongation|déformation", re.I)
_TRAVEL = re.compile(r"extension|displacement|crosshead|travel|weg\b|traverse|position", re.I)
_STRESS = re.compile(r"stress|spannung|contrainte", re.I)
_FORCE = re.compile(r"force|load|kraft|\blast\b", re.I)
_NOT_STRAIN = re.compile(r"\btrue\b|rate|geschwindigkeit|lateral|transverse|quer|wahre", re.I)
_SAMPLE = re.compile(r"sample|specimen|probe|éprouvette", re.I)
STRETCH = re.compile(r"stretch|lambda|λ|verstreckung", re.I)
_SHORT = re.compile(r"[ _-](?:ut|uc|et|ps)\d*$", re.I)
"""Short name of a test at the end of a column's name."""
_STRAIN_UNITS = {
    "mm/mm": StrainUnit.RATIO,
    "m/m": StrainUnit.RATIO,
    "-": StrainUnit.RATIO,
    "1": StrainUnit.RATIO,
    "%": StrainUnit.PERCENT,
    "percent": StrainUnit.PERCENT,
    "mm": StrainUnit.TRAVEL,
    "stretch": StrainUnit.STRETCH,
    "log": StrainUnit.LOGARITHMIC,
}
_STRESS_UNITS = {unit.lower(): unit for unit in StressUnit} | {
    "n/mm2": StressUnit.MPA,
    "n/mm²": StressUnit.MPA,
    "n/mm^2": StressUnit.MPA,
}
_GREATEST_RATIO = 25.0
"""No elastomer bears more; a greater strain without unit may be in per cent."""


@dataclass(frozen=True)
class Pair:
    """Columns of one sample, from 0, with the units of all."""

    strain: int
    stress: int


@dataclass(frozen=True)
class Columns:
    """Where the samples of a table stand.

    Attributes
    ----------
    pairs
        Columns of strain and stress; several where the samples stand side by side.
    strain_unit, stress_unit
        Their units.
    sample
        Column that numbers the samples; none where there is none.
    """

    pairs: tuple[Pair, ...]
    strain_unit: StrainUnit
    stress_unit: StressUnit
    sample: int | None


def find_columns(table: Table, spec: TestFileSpec) -> Columns:
    """Find columns and units from the spec, or else from the header.

    Raises
    ------
    PalpateError
        If a column is missing, stands twice, or its unit is not said; the message names the columns there are.
    """
    strains = _find(table, spec.strain, "strain", (_STRAIN, _TRAVEL))
    stresses = _find(table, spec.stress, "stress", (_STRESS, _FORCE))
    if len(strains) != len(stresses) or (len(strains) > 1 and not _alternate(strains, stresses)):
        kind, several = ("strain", strains) if len(strains) > 1 else ("stress", stresses)
        raise _several(table, kind, several)
    pairs = tuple(Pair(a, b) for a, b in zip(strains, stresses, strict=True))
    _check_apart(table, pairs)
    return Columns(
        pairs=pairs,
        strain_unit=_strain_unit(table, pairs, spec),
        stress_unit=_stress_unit(table, pairs, spec),
        sample=_sample_column(table, spec),
    )


def find_column(table: Table, given: str | None, kind: str, pattern: re.Pattern[str]) -> int:
    """Column, from 0, that is given by name or number, or else the only one whose name has the pattern.

    Raises
    ------
    PalpateError
        If there is none or several; the message names the columns there are.
    """
    found = seek_column(table, given, kind, pattern)
    if found is None:
        raise PalpateError(
            f"{table.path}: no column is called {kind}; there are {_listed(table)}.",
            f"Say which: --{kind} NAME or NUMBER.",
            code="column-missing",
        )
    return found


def seek_column(table: Table, given: str | None, kind: str, pattern: re.Pattern[str]) -> int | None:
    """Column as `find_column` finds it; `None` where no name has the pattern."""
    if given is not None:
        return _named(table, given, kind)[0]
    found = _matching(table, pattern)
    if len(found) > 1:
        raise _several(table, kind, found)
    return found[0] if found else None


def units_of_column(table: Table, column: int) -> set[str]:
    """Texts that may be a column's unit: from the row of units, in brackets or at the end of its name."""
    found = {table.units[column].strip("()[] ")} if table.units else set()
    if table.header:
        name = _SHORT.sub("", table.header[column])
        tail = re.search(r"(?:_|\s+in\s+|\s/\s*|,\s*)([A-Za-z%²/0-9^]+)$", name)
        found |= {*re.findall(r"[\(\[]\s*(.*?)\s*[\)\]]", name), *([tail[1]] if tail else [])}
    return found - {""}


def _find(table: Table, given: str | None, kind: str, patterns: tuple[re.Pattern[str], ...]) -> list[int]:
    if given is not None:
        return _named(table, given, kind)
    for pattern in patterns:
        if found := _matching(table, pattern):
            return found
    raise PalpateError(
        f"{table.path}: no column is called {kind}; there are {_listed(table)}.",
        f"Say which: --{kind} NAME or NUMBER, and --{kind}-unit.",
        code="column-missing",
    )


def _matching(table: Table, pattern: re.Pattern[str]) -> list[int]:
    """Columns whose names have the pattern, without rates and the like."""
    return [at for at, name in enumerate(table.header) if pattern.search(name) and not _NOT_STRAIN.search(name)]


def _several(table: Table, kind: str, columns: list[int]) -> PalpateError:
    shown = ", ".join(f"{column + 1} ({table.header[column]})" for column in columns)
    return PalpateError(
        f"{table.path}: columns {shown} may all be the {kind}.",
        f"Choose one: --{kind} NUMBER.",
        code="column-ambiguous",
    )


def _named(table: Table, given: str, kind: str) -> list[int]:
    names = [name.lower() for name in table.header]
    bare = [_bare(name).lower() for name in table.header]
    wanted = given.strip().lower()
    exact = [at for at, name in enumerate(names) if name == wanted]
    found = exact or [at for at, name in enumerate(bare) if name == wanted]
    if not found and given.strip().isdigit() and 1 <= int(given) <= table.values.shape[1]:
        found = [int(given) - 1]
    if len(found) == 1:
        return found
    what = f"there is no column '{given}'" if not found else f"'{given}' stands {len(found)} times"
    raise PalpateError(
        f"{table.path}: {what}; there are {_listed(table)}.",
        f"Give its number: --{kind} NUMBER.",
        code="column-ambiguous" if found else "column-unknown",
    )


def _listed(table: Table) -> str:
    count = table.values.shape[1]
    names = table.header or ("without name",) * count
    return ", ".join(f"{at} ({name})" for at, name in enumerate(names, start=1))


def _alternate(strains: list[int], stresses: list[int]) -> bool:
    """Whether strain and stress take turns: samples side by side."""
    turns = sorted([*strains, *stresses])
    return turns[0::2] in (strains, stresses) and turns[1::2] in (strains, stresses)


def _check_apart(table: Table, pairs: tuple[Pair, ...]) -> None:
    for pair in pairs:
        if pair.strain == pair.stress:
            raise PalpateError(
                f"{table.path}: column {pair.strain + 1} is both strain and stress.",
                "Give --strain and --stress.",
                code="column-taken-twice",
            )


def _bare(name: str) -> str:
    """A column's name without its unit."""
    return re.sub(r"\s*[\(\[].*?[\)\]]\s*$", "", name).strip()


def _written_units(table: Table, column: int) -> set[str]:
    """Units of strain or stress written for a column."""
    found = units_of_column(table, column)
    return {text for text in found if text.lower() in _STRAIN_UNITS or text.lower() in _STRESS_UNITS}


def _strain_unit(table: Table, pairs: tuple[Pair, ...], spec: TestFileSpec) -> StrainUnit:
    if spec.strain_unit is not None:
        return spec.strain_unit
    column = pairs[0].strain
    name = table.header[column] if table.header else ""
    if STRETCH.search(name):
        return StrainUnit.STRETCH
    written = {text for pair in pairs for text in _written_units(table, pair.strain)}
    units = {_STRAIN_UNITS[text.lower()] for text in written if text.lower() in _STRAIN_UNITS}
    if len(units) == 1:
        return units.pop()
    greatest = np.nanmax(np.abs(table.values[:, column]), initial=0.0)
    if not units and _STRAIN.search(name) and greatest <= _GREATEST_RATIO:
        return StrainUnit.RATIO
    said = f"in {' and in '.join(sorted(units))}" if units else f"up to {greatest:g} without a unit"
    raise PalpateError(
        f"{table.path}: the strain (column {column + 1}) is {said}.",
        f"Give --strain-unit: {', '.join(StrainUnit)}.",
        code="column-unit-unknown",
    )


def _stress_unit(table: Table, pairs: tuple[Pair, ...], spec: TestFileSpec) -> StressUnit:
    if spec.stress_unit is not None:
        return spec.stress_unit
    written = {text for pair in pairs for text in _written_units(table, pair.stress)}
    units = {_STRESS_UNITS[text.lower()] for text in written if text.lower() in _STRESS_UNITS}
    if len(units) == 1 and "mPa" not in written:
        return units.pop()
    said = f"in {' and in '.join(sorted(written))}" if written else "without a unit"
    raise PalpateError(
        f"{table.path}: the stress (column {pairs[0].stress + 1}) is {said}.",
        f"Give --stress-unit: {', '.join(StressUnit)}.",
        code="column-unit-unknown",
    )


def _sample_column(table: Table, spec: TestFileSpec) -> int | None:
    if spec.sample is not None:
        return _named(table, spec.sample, "sample")[0]
    found = [at for at, name in enumerate(table.header) if _SAMPLE.search(name) and not _STRESS.search(name)]
    found = [at for at in found if not (_STRAIN.search(table.header[at]) or _TRAVEL.search(table.header[at]))]
    found = [at for at in found if not _FORCE.search(table.header[at])]
    if len(found) > 1:
        shown = ", ".join(f"{column + 1} ({table.header[column]})" for column in found)
        raise PalpateError(
            f"{table.path}: columns {shown} may all number the samples.",
            "Choose one: --sample NUMBER.",
            code="column-ambiguous",
        )
    return found[0] if found else None
