"""Columns of strain and stress in a table of a test machine, and their units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import PalpateError
from palpate.core.tables import Fault, Table, read_table
from palpate.core.units import split_unit
from palpate.material.spec import DECIMALS, DELIMITERS, StrainUnit, StressUnit, TestFileSpec

STRAIN = re.compile(
    r"strain|stretch|lambda|λ|dehnung|stauchung|elongation|verstreckung|d[ée]formation|allongement"
    r"|deforma[zc]i[oó]ne?\b|deformação|allungamento|alargamiento|应变|伸长|拉伸比|ひずみ|歪|伸び",
    re.I,
)
_TRAVEL = re.compile(
    r"extension|displacement|crosshead|travel|weg\b|traverse|position|d[ée]placement|spostamento|desplazamiento"
    r"|deslocamento|位移|变形|変位|ストローク",
    re.I,
)
_LETTERS = {
    kind: re.compile(rf"(?:{letter})(?:[_ ](?:eng|nom|true)\w*)?\s*(?:[\[(/,].*)?$", re.I)
    for kind, letter in (("strain", "^ε|^ϵ|^epsilon"), ("stress", "^sigma"))
}
"""Letters of strain and stress, which count if no column has a word for one or for travel or force."""
_SELDOM = re.compile(
    r"stroke|separation|deflection|distance|\bhub\b|l[äa]ngen[äa]nderung|verl[äa]ngerung|verformung|\bcourse\b|行程",
    re.I,
)
"""Names of travel that other columns of the same file may have too."""
_UNNAMED = re.compile(r"(?:ch|channel|col|column|value|signal|d?[a-z])?[ _-]?\d*", re.I)
"""Names that state no quantity."""
STRESS = re.compile(r"stress|spannung|contrainte|sforzo|esfuerzo|tensão|应力|応力|σ", re.I)
_FORCE = re.compile(
    r"force|load|kraft|\blast\b|\bcharge\b|\bcarico\b|\bcarga\b|forza|fuerza|força|载荷|荷重|力", re.I
)
_NOT_STRAIN = re.compile(
    r"rate\b|geschwindigkeit|vitesse|velocid|velocit|tasa|lateral|transverse?al|\btransverse|quer|break|bruch|速|横|max",
    re.I,
)
_TRUE = re.compile(r"\btrue\b|_true|true_|wahre|\bvraie?\b|真|cauchy|hencky|\blog(?:arithmi\w*)?\b|\bln\b", re.I)
_SAMPLE = re.compile(r"sample|specimen|probe|éprouvette|试样|試験片", re.I)
STRETCH = re.compile(r"stretch|lambda|λ|verstreckung|拉伸比", re.I)
FORCE_NAMES = (_FORCE, _LETTERS["stress"])
"""Patterns of names of force, which count if no column is called stress."""
_STRAIN_UNITS = {
    **dict.fromkeys(("mm/mm", "m/m", "in/in", "-", "–", "1"), (StrainUnit.RATIO, 1.0)),
    **dict.fromkeys(("%", "percent", "pct", "百分比"), (StrainUnit.PERCENT, 1.0)),
    **dict.fromkeys(("uε", "ue", "ustrain", "microstrain"), (StrainUnit.RATIO, 1e-6)),
    **dict.fromkeys(("mm", "毫米"), (StrainUnit.TRAVEL, 1.0)),
    **{unit: (StrainUnit.TRAVEL, factor) for unit, factor in (("cm", 10.0), ("m", 1e3), ("um", 1e-3))},
    **dict.fromkeys(("in", "inch", "inches"), (StrainUnit.INCH, 1.0)),
    "stretch": (StrainUnit.STRETCH, 1.0),
    "log": (StrainUnit.LOGARITHMIC, 1.0),
}
"""Unit of strain as tables write it, and the factor to the unit named."""
_STRESS_UNITS = {unit.lower(): unit for unit in StressUnit} | {
    **dict.fromkeys(("n/mm2", "兆帕"), StressUnit.MPA),
    **dict.fromkeys(("n/m2",), StressUnit.PA),
    **dict.fromkeys(("千帕",), StressUnit.KPA),
    **dict.fromkeys(("kg/cm2", "kp/cm2"), StressUnit.KGF_PER_CM2),
    **dict.fromkeys(("kg/mm2", "kp/mm2"), StressUnit.KGF_PER_MM2),
    **dict.fromkeys(("lbf/in2", "lb/in2"), StressUnit.PSI),
    **dict.fromkeys(("lb", "lbs"), StressUnit.POUND_FORCE),
    **dict.fromkeys(("kg", "kp"), StressUnit.KILOGRAM_FORCE),
    **dict.fromkeys(("g",), StressUnit.GRAM_FORCE),
    **dict.fromkeys(("牛", "牛顿"), StressUnit.NEWTON),
}
_GAUGE_LENGTHS = (5.0, 250.0)
"""Gauge lengths of specimens, mm (ISO 37: 10 to 25; D412: 25 to 33; long strips and blocks)."""
_ALIKE = 0.02
"""Maximum difference of a true strain from the logarithm of the stretch for the two columns to agree.
By hand."""
MAX_STRAIN = 12.0
"""Strain at rupture of the softest silicones; a larger one without a unit may be in per cent."""


@dataclass(frozen=True)
class Pair:
    """Columns of one sample, from 0, with the units of all."""

    strain: int
    stress: int


@dataclass(frozen=True)
class Columns:
    """Columns of the samples in a table.

    Attributes
    ----------
    pairs
        Columns of strain and stress; several if the samples are side by side.
    strain_unit, stress_unit
        Their units.
    strain_factor
        Numbers of the strain column to its unit.
    strain_assumed
        Whether the file does not state the unit of strain.
    true_strain, true_stress
        Whether the columns are called true.
    sample
        Column that numbers or names the samples; `None` without one.
    """

    pairs: tuple[Pair, ...]
    strain_unit: StrainUnit
    stress_unit: StressUnit
    strain_factor: float
    strain_assumed: bool
    true_strain: bool
    true_stress: bool
    sample: int | None


MAX_ROWS = 50_000
"""Rows beyond these are thinned evenly: no curve needs more."""


def read_columns(path: Path, spec: TestFileSpec) -> Table:
    """Read the table of a test file in the dialect that the spec states, or that is found."""
    delimiter = DELIMITERS[spec.delimiter] if spec.delimiter else None
    decimal = DECIMALS[spec.decimal] if spec.decimal else None
    return read_table(path, delimiter=delimiter, decimal=decimal, max_rows=MAX_ROWS)


def refuse_faults(table: Table, column: int) -> None:
    """Refuse a column of numbers that has a cell of text.

    Raises
    ------
    PalpateError
        With row, column and text of the cell.
    """
    fault = table.faults.get(column)
    if fault is None and not table.is_numeric(column):
        fault = Fault(int(table.lines[0]), str(table.columns[column][0]))
    if fault is not None:
        raise PalpateError(
            f"{table.path}: row {fault.line}, {_label(table, column)}: '{fault.text[:40]}' is no number.",
            _correct(fault.text, table.decimal),
            code="value-not-number",
        )


def empty_cell(table: Table, line: int, column: int) -> PalpateError:
    """The error of a cell without a number."""
    return PalpateError(
        f"{table.path}: row {line}, {_label(table, column)} is empty.", "Fill or delete the row.", code="cell-empty"
    )


def _label(table: Table, column: int) -> str:
    return f"column {column + 1}" + (f" ({table.header[column]})" if table.header[column] else "")


def _correct(cell: str, decimal: str) -> str:
    if re.fullmatch(r"[-+]?[\d.,]+(?:[eE][-+]?\d+)?", cell):
        mark = "comma" if decimal == "," else "point"
        return f"The decimal mark of this file is the {mark}: write one mark throughout, and none for thousands."
    if re.match(r"[-+]?[\d.,]+\s*[A-Za-z%]", cell):
        return "Write numbers only, and the unit in the header."
    return "Correct or delete the row, or put # in front of it."


def find_columns(table: Table, spec: TestFileSpec) -> Columns:
    """Find columns and units from the spec, or else from the header.

    Raises
    ------
    PalpateError
        If a column is missing or ambiguous, or its unit is not stated; the message lists the columns.
    """
    strains = _find(table, spec.strain, "strain", (STRAIN, _TRAVEL, _SELDOM, _LETTERS["strain"]))
    stresses = _find(table, spec.stress, "stress", (STRESS, *FORCE_NAMES))
    if len(strains) != len(stresses) or (len(strains) > 1 and not _alternate(strains, stresses)):
        kind, several = ("strain", strains) if len(strains) > 1 else ("stress", stresses)
        raise _several(table, kind, several)
    pairs = tuple(Pair(a, b) for a, b in zip(strains, stresses, strict=True))
    for pair in pairs:
        if pair.strain == pair.stress:
            raise PalpateError(
                f"{table.path}: column {pair.strain + 1} is both strain and stress.",
                "Give --strain and --stress.",
                code="column-taken-twice",
            )
        refuse_faults(table, pair.strain)
        refuse_faults(table, pair.stress)
    strain_unit, factor, assumed = _strain_unit(table, pairs, spec)
    return Columns(
        pairs=pairs,
        strain_unit=strain_unit,
        stress_unit=_stress_unit(table, pairs, spec),
        strain_factor=factor,
        strain_assumed=assumed,
        true_strain=spec.strain_unit is None and bool(_TRUE.search(table.header[strains[0]])),
        true_stress=spec.true_stress or bool(_TRUE.search(table.header[stresses[0]])),
        sample=_sample_column(table, spec),
    )


def find_column(table: Table, given: str | None, kind: str, patterns: Sequence[re.Pattern[str]]) -> int:
    """Column, from 0, by its name or number if given, else by the first pattern that a name has.

    Raises
    ------
    PalpateError
        If no column or several match that pattern; the message names the columns there are.
    """
    found = seek_column(table, given, kind, patterns)
    if found is None:
        raise PalpateError(
            f"{table.path}: no column is called {kind}; there are {_listed(table)}.",
            f"Choose one: --{kind} NAME or NUMBER.",
            code="column-missing",
        )
    return found


def seek_column(table: Table, given: str | None, kind: str, patterns: Sequence[re.Pattern[str]]) -> int | None:
    """Column as `find_column` finds it; `None` if no name matches a pattern."""
    if given is not None:
        return _named(table, given, kind)[0]
    found = next(filter(None, (_matching(table, pattern) for pattern in patterns)), [])
    if len(found) > 1:
        raise _several(table, kind, found)
    return found[0] if found else None


def _find(table: Table, given: str | None, kind: str, patterns: tuple[re.Pattern[str], ...]) -> list[int]:
    if given is not None:
        return _named(table, given, kind)
    for pattern in patterns:
        found = _matching(table, pattern)
        if found := [at for at in found if not _TRUE.search(table.header[at])] or found:
            return found
    known = _STRESS_UNITS.keys() if kind == "stress" else _STRAIN_UNITS.keys() - {"-", "–", "1"}
    found = [at for at in range(len(table.columns)) if known & {text.lower() for text in _written(table, [at])}]
    found = [at for at in found if table.is_numeric(at)]
    if len(found) == 1 and _UNNAMED.fullmatch(table.bare_names()[found[0]]):
        return found
    raise PalpateError(
        f"{table.path}: no column is called {kind}; there are {_listed(table)}.",
        f"Choose one: --{kind} NAME or NUMBER, and --{kind}-unit.",
        code="column-missing",
    )


def _matching(table: Table, pattern: re.Pattern[str]) -> list[int]:
    """Columns whose names have the pattern, without rates and the like."""
    found = [at for at, name in enumerate(table.header) if pattern.search(name) and not _NOT_STRAIN.search(name)]
    return [at for at in found if table.is_numeric(at)] or found


def _several(table: Table, kind: str, columns: list[int]) -> PalpateError:
    shown = ", ".join(f"{column + 1} ({table.header[column]})" for column in columns)
    return PalpateError(
        f"{table.path}: columns {shown} may all be the {kind}.",
        f"Choose one: --{kind} NUMBER.",
        code="column-ambiguous",
    )


def _named(table: Table, given: str, kind: str) -> list[int]:
    names = [name.lower() for name in table.header]
    bare = [name.lower() for name in table.bare_names()]
    wanted = given.strip().lower()
    exact = [at for at, name in enumerate(names) if name == wanted]
    found = exact or [at for at, name in enumerate(bare) if name == wanted]
    if not found and given.strip().isdigit() and 1 <= int(given) <= len(table.columns):
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
    count = len(table.columns)
    names = ", ".join(f"{at} ({name or 'without name'})" for at, name in enumerate(table.header[:20], start=1))
    return names + (f" and {count - 20} more" if count > 20 else "")


def _alternate(strains: list[int], stresses: list[int]) -> bool:
    """Whether strain and stress columns alternate: samples side by side."""
    turns = sorted([*strains, *stresses])
    return turns[0::2] in (strains, stresses) and turns[1::2] in (strains, stresses)


def _written(table: Table, columns: list[int]) -> set[str]:
    """Units that are written for columns, in one form."""
    texts = {table.unit(column).strip() for column in columns}
    if table.units:
        texts |= {split_unit(table.header[column])[1] for column in columns}
    forms = str.maketrans({"²": "2", "^": "", "µ": "u", "μ": "u", " ": "", "·": ""})
    return {text.translate(forms) for text in texts if text}


def _strain_unit(table: Table, pairs: tuple[Pair, ...], spec: TestFileSpec) -> tuple[StrainUnit, float, bool]:
    """Unit of strain, its factor, and whether it is assumed."""
    if spec.strain_unit is not None:
        return spec.strain_unit, 1.0, False
    column = pairs[0].strain
    name = table.header[column]
    written = _written(table, [pair.strain for pair in pairs])
    units = {_STRAIN_UNITS[text.lower()] for text in written if text.lower() in _STRAIN_UNITS}
    if STRETCH.search(name) and not _TRUE.search(name):
        return StrainUnit.STRETCH, (0.01 if units == {(StrainUnit.PERCENT, 1.0)} else 1.0), False
    if len(units) == 1:
        return (*units.pop(), False)
    maximum = np.nanmax(np.abs(table.numbers(column)), initial=0.0)
    if not units and (STRAIN.search(name) or _LETTERS["strain"].search(name)):
        if _is_ratio(table, column):
            return StrainUnit.RATIO, 1.0, False
        if maximum <= MAX_STRAIN:
            return StrainUnit.RATIO, 1.0, True
    said = (
        f"in {' and in '.join(sorted(unit for unit, _ in units))}" if units else f"up to {maximum:g} without a unit"
    )
    raise PalpateError(
        f"{table.path}: the strain (column {column + 1}) is {said}.",
        f"Give --strain-unit: {', '.join(StrainUnit)}.",
        code="column-unit-unknown",
    )


def _is_ratio(table: Table, column: int) -> bool:
    """Whether travel or true strain shows that a strain without a unit is a ratio."""
    strain = table.numbers(column)
    rows = np.abs(strain) > 0.1 * np.nanmax(np.abs(strain), initial=0.0)
    others = [at for at, name in enumerate(table.header) if at != column and name and table.is_numeric(at)]
    for at in others if rows.any() else []:
        other = table.numbers(at)[rows]
        if _TRAVEL.search(table.header[at]) and _written(table, [at]) & {"mm", "毫米"}:
            gauge = float(np.median(np.abs(other / strain[rows])))
            if _GAUGE_LENGTHS[0] <= gauge <= _GAUGE_LENGTHS[1]:
                return True
        if STRAIN.search(table.header[at]) and _TRUE.search(table.header[at]):
            return bool(np.nanmedian(np.abs(other - np.log1p(np.maximum(strain[rows], -0.99)))) < _ALIKE)
    return False


def _stress_unit(table: Table, pairs: tuple[Pair, ...], spec: TestFileSpec) -> StressUnit:
    if spec.stress_unit is not None:
        return spec.stress_unit
    written = _written(table, [pair.stress for pair in pairs])
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
    found = [at for at, name in enumerate(table.header) if _SAMPLE.search(name) and not STRESS.search(name)]
    found = [at for at in found if not (STRAIN.search(table.header[at]) or _TRAVEL.search(table.header[at]))]
    found = [at for at in found if not _FORCE.search(table.header[at])]
    if len(found) > 1:
        shown = ", ".join(f"{column + 1} ({table.header[column]})" for column in found)
        raise PalpateError(
            f"{table.path}: columns {shown} may all number the samples.",
            "Choose one: --sample NUMBER.",
            code="column-ambiguous",
        )
    return found[0] if found else None
