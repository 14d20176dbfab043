"""Samples from the file of a test machine: stretch and nominal stress of an incompressible specimen."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.core.tables import Table
from palpate.material.columns import MAX_STRAIN, Columns, Pair, empty_cell, find_columns, read_columns
from palpate.material.cycles import select_cycle
from palpate.material.sample import Loading, Sample
from palpate.material.spec import StrainUnit, StressUnit, TestFileSpec

LEAST_ROWS = 5
"""Minimum number of rows of a curve. By hand."""
_MOST_SAMPLES = 100
"""Maximum number of samples in a file. By hand."""
_WORDS = {
    Loading.TENSION: r"tension|tensile|zug|traction|d412|iso[ _-]?37\b|pull|单轴拉伸|拉伸|引張",
    Loading.COMPRESSION: r"compress|druck|d395|d575|iso[ _-]?7743|stauchversuch|压缩|圧縮",
    Loading.EQUIBIAXIAL: r"biaxial|bulge|双轴|二軸",
    Loading.PLANAR: r"planar|pure[ _-]?shear|平面|純せん断",
    Loading.UNIAXIAL: r"(?<!equi)(?<!bi)uniaxial|einachsig",
}
_SHORT = {
    Loading.TENSION: r"(?<![a-z0-9])ut(?![a-z])",
    Loading.COMPRESSION: r"(?<![a-z0-9])uc(?![a-z])",
    Loading.EQUIBIAXIAL: r"(?<![a-z0-9])et(?![a-z])",
    Loading.PLANAR: r"(?<![a-z0-9])ps(?![a-z])",
}
"""Short names of the tests, in names of files and columns only: in a sentence, *et* is a word."""
_MPA = {
    StressUnit.PA: 1e-6,
    StressUnit.KPA: 1e-3,
    StressUnit.MPA: 1.0,
    StressUnit.GPA: 1e3,
    StressUnit.N_PER_CM2: 0.01,
    StressUnit.PSI: 6.894757293168e-3,
    StressUnit.BAR: 0.1,
    StressUnit.KGF_PER_CM2: 0.0980665,
    StressUnit.KGF_PER_MM2: 9.80665,
    StressUnit.MILLINEWTON: 1e-3,
    StressUnit.NEWTON: 1.0,
    StressUnit.KILONEWTON: 1e3,
    StressUnit.POUND_FORCE: 4.4482216152605,
    StressUnit.KILOGRAM_FORCE: 9.80665,
    StressUnit.GRAM_FORCE: 9.80665e-3,
}
"""MPa a unit, or N a unit of force."""
_FORCES = tuple(_MPA)[list(_MPA).index(StressUnit.MILLINEWTON) :]
_INCH = 25.4
"""Millimetres an inch."""
_MODULI = (1e-3, 200.0)
"""Young's moduli of elastomers in MPa: from gels of 1 kPa to polyurethanes of 200 MPa, with a margin."""
_ASSUMED_MODULUS = 0.01
"""MPa below which a strain without a unit is questioned: the softest silicone of molds has 15 kPa."""


def read_test_file(path: str | Path, spec: TestFileSpec | None = None) -> tuple[Sample, ...]:
    """Read the samples of a file.

    Parameters
    ----------
    path
        CSV or other text with columns of strain (or stretch, or travel) and stress (or force).
    spec
        Format that the file does not state.

    Returns
    -------
    tuple of Sample
        In the order of the file. Compression is negative, whatever the sign in the file.

    Raises
    ------
    PalpateError
        If the file is wrong or ambiguous; the message names row, column and remedy.
    """
    path, spec = Path(path), spec or TestFileSpec()
    table = read_columns(path, spec)
    columns = find_columns(table, spec)
    notes = tuple(_notes(table, columns))
    samples = []
    for label, pair, rows in _split(table, columns):
        loading = _find_loading(table, pair, spec)
        strain, stress, lines = _take(table, pair, rows)
        strain = columns.strain_factor * strain
        name = path.name + (f" {label}" if label else "")
        stretch, nominal = _to_stretch(strain, columns, spec, path), _to_stress(stress, columns, spec, path)
        stretch, nominal = _signed(stretch, nominal, loading, path)
        bad = np.flatnonzero(~(stretch > 0))
        if len(bad):
            raise PalpateError(
                f"{path}: row {lines[bad[0]]}, column {pair.strain + 1}: the stretch is {stretch[bad[0]]:.4g}.",
                "A stretch is positive: check the unit of strain, and whether this is tension or compression.",
                code="stretch-not-positive",
            )
        if columns.true_stress:
            nominal = nominal / stretch
        samples.append(Sample(name, loading, stretch, nominal, notes))
    for sample in samples:
        _check(sample, path, columns, spec)
    return tuple(state for sample in samples for state in select_cycle(sample, spec.cycle))


def _notes(table: Table, columns: Columns) -> Iterator[str]:
    """Notes on further contents of the file, and on assumptions."""
    if table.skipped:
        yield f"{table.skipped} of {table.skipped + len(table)} rows thinned away"
    words = [name for at, name in enumerate(table.header) if name and not table.is_numeric(at)]
    if words:
        yield f"columns of words passed over: {', '.join(words[:6])}"
    yield from table.notes
    if columns.true_strain or columns.true_stress:
        names = " and ".join(["strain"] * columns.true_strain + ["stress"] * columns.true_stress)
        yield f"true {names} converted"


def _blocks(table: Table, strain: FloatArray) -> FloatArray:
    """(n,) number of the specimen, for specimens below each other.

    A specimen begins where the strain returns to its start: at a heading or blank line, or from one row to the next.
    """
    known = np.flatnonzero(np.isfinite(strain))
    number = np.zeros(len(strain), int)
    if len(known) < 2 * LEAST_ROWS:
        return number
    values = strain[known]
    span = max(float(np.ptp(values)), 1e-300)
    away = np.abs(values - values[0])
    back = away[1:] < 0.1 * span
    jump = (away[:-1] > 0.5 * span) & back
    if np.any((np.abs(np.diff(values)) > 0.25 * span) & ~jump):  # rows in no order
        jump[:] = False
    heading = (np.diff(table.block[known]) > 0) & back
    number[known[1:][jump | heading]] = 1
    return np.cumsum(number)


def _split(table: Table, columns: Columns) -> Iterator[tuple[str, Pair, FloatArray]]:
    """Label, columns and rows (mask) of each sample."""
    if columns.sample is None:
        found = []
        for pair in columns.pairs:
            number = _blocks(table, table.numbers(pair.strain))
            found += [(pair, number == at) for at in np.unique(number)]
        for at, (pair, rows) in enumerate(found, start=1):
            yield (f"sample {at}" if len(found) > 1 else ""), pair, rows
        return
    ids = table.columns[columns.sample]
    empty = np.flatnonzero(np.isnan(ids) if table.is_numeric(columns.sample) else ids == "")
    if len(empty):
        raise PalpateError(
            f"{table.path}: row {table.lines[empty[0]]} has no number of a sample (column {columns.sample + 1}).",
            "Fill the cell.",
            code="cell-empty",
        )
    found = list(dict.fromkeys(ids.tolist()))
    if len(found) > _MOST_SAMPLES:
        raise PalpateError(
            f"{table.path}: column {columns.sample + 1} numbers {len(found)} samples.",
            "Give the column that numbers them by --sample.",
            code="sample-count-wrong",
        )
    for label in found:
        for pair in columns.pairs:
            yield f"sample {label:g}" if isinstance(label, float) else f"sample {label}", pair, ids == label


def _take(table: Table, pair: Pair, rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Strain, stress and lines of a sample; rows at the end where both cells are empty are left out."""
    strain, stress = table.numbers(pair.strain)[rows], table.numbers(pair.stress)[rows]
    lines = table.lines[rows]
    filled = np.flatnonzero(~(np.isnan(strain) & np.isnan(stress)))
    end = int(filled[-1]) + 1 if len(filled) else 0
    strain, stress, lines = strain[:end], stress[:end], lines[:end]
    gaps = np.flatnonzero(np.isnan(strain) | np.isnan(stress))
    if len(gaps):
        raise empty_cell(table, lines[gaps[0]], pair.strain if np.isnan(strain[gaps[0]]) else pair.stress)
    if end < LEAST_ROWS:
        raise PalpateError(
            f"{table.path} has {end} row{'s' if end != 1 else ''} of numbers.",
            f"A curve needs {LEAST_ROWS} or more: export the whole test.",
            code="table-few-rows",
        )
    return strain, stress, np.asarray(lines)


def _to_stretch(strain: FloatArray, columns: Columns, spec: TestFileSpec, path: Path) -> FloatArray:
    unit = columns.strain_unit
    if unit in (StrainUnit.TRAVEL, StrainUnit.INCH):
        if spec.gauge_length is None:
            raise PalpateError(
                f"{path}: column {columns.pairs[0].strain + 1} is travel in {unit}.",
                "Give the --gauge-length in mm.",
                code="gauge-length-missing",
            )
        return np.asarray(1 + (_INCH if unit is StrainUnit.INCH else 1.0) * strain / spec.gauge_length)
    if unit is StrainUnit.STRETCH:
        return strain
    strain = (0.01 if unit is StrainUnit.PERCENT else 1.0) * strain
    if unit is StrainUnit.LOGARITHMIC or columns.true_strain:
        return np.asarray(np.exp(np.clip(strain, -50.0, 50.0)))
    return np.asarray(1 + strain)


def _to_stress(stress: FloatArray, columns: Columns, spec: TestFileSpec, path: Path) -> FloatArray:
    if columns.stress_unit not in _FORCES:
        return _MPA[columns.stress_unit] * stress
    if spec.section is None:
        raise PalpateError(
            f"{path}: column {columns.pairs[0].stress + 1} is a force in {columns.stress_unit}.",
            "Give the undeformed --section in mm².",
            code="section-missing",
        )
    return _MPA[columns.stress_unit] * stress / spec.section


def _signed(stretch: FloatArray, nominal: FloatArray, loading: Loading, path: Path) -> tuple[FloatArray, FloatArray]:
    """Stretch and stress with compression negative; a machine may write it as positive."""
    strain = stretch - 1
    far = strain[np.argmax(np.abs(strain))]
    if loading is Loading.COMPRESSION:
        strain = -strain if far > 0 else strain
        peak = nominal[np.argmax(np.abs(nominal))]
        return 1 + strain, (-nominal if peak > 0 else nominal)
    if loading is Loading.TENSION and far < 0:
        raise PalpateError(
            f"{path} is read as tension, but its strain reaches {far:.3g}.",
            "Give the file to --compression, or to --uniaxial if it holds both.",
            code="tension-strain-negative",
        )
    return stretch, nominal


def _find_loading(table: Table, pair: Pair, spec: TestFileSpec) -> Loading:
    """Test of a pair of columns, by the spec, the names of file and columns, or the preamble."""
    if spec.loading is not None:
        return spec.loading
    used = f"{table.header[pair.strain]} {table.header[pair.stress]}".lower()
    name = table.path.stem.lower()
    places = ((_WORDS, name), (_SHORT, name), (_WORDS, used), (_SHORT, used))
    several: list[Loading] = []
    for words, place in (*places, (_WORDS, " ".join(table.preamble).lower())):
        if several and place not in (name, used):
            break
        found = [loading for loading, pattern in words.items() if re.search(pattern, place)]
        if len(found) == 2 and Loading.UNIAXIAL in found and place in (name, used):  # uniaxial tension
            found.remove(Loading.UNIAXIAL)
        if len(found) == 1:
            return found[0]
        several = several or found
    said = f"may be {' or '.join(several)}" if several else "does not state which test it is"
    flags = ", ".join(f"--{loading}" for loading in Loading)
    raise PalpateError(
        f"{table.path} {said}.", f"Give it to one of {flags}, or name the file after its test.", code="test-unknown"
    )


def _check(sample: Sample, path: Path, columns: Columns, spec: TestFileSpec) -> None:
    """Reject a sample that cannot be a curve."""
    if np.ptp(sample.stretch) < 1e-3:
        raise PalpateError(
            f"{path}: the stretch stays at {sample.stretch[0]:.4g}.",
            "Check the column and unit of strain.",
            code="stretch-constant",
        )
    if np.ptp(sample.nominal) <= 0:
        raise PalpateError(
            f"{path}: the stress stays at {sample.nominal[0]:g} MPa.",
            "Check the column of stress.",
            code="stress-constant",
        )
    most = 1 + (MAX_STRAIN if columns.strain_assumed else 25)
    if sample.stretch.max() > most or sample.stretch.min() < 0.01:
        raise PalpateError(
            f"{path}: the stretch goes from {sample.stretch.min():.3g} to {sample.stretch.max():.4g}.",
            "No elastomer bears that: check gauge length and unit of strain; --strain-unit states it.",
            code="stretch-implausible",
        )
    if np.abs(sample.nominal).max() > 1e3:
        raise PalpateError(
            f"{path}: the stress reaches {np.abs(sample.nominal).max():.4g} MPa.",
            "No elastomer bears that: check the unit of stress and the section.",
            code="stress-implausible",
        )
    against = np.sum((sample.stretch - 1) * sample.nominal)
    if against <= 0:
        raise PalpateError(
            f"{path}: the stress has the sign against the strain.",
            "Check the columns, or give --compression.",
            code="stress-sign-wrong",
        )
    _question(sample, path, columns, spec)


def _question(sample: Sample, path: Path, columns: Columns, spec: TestFileSpec) -> None:
    """Reject a modulus outside the range of elastomers, unless the user states the units."""
    if spec.strain_unit is not None and spec.stress_unit is not None:
        return
    away = np.abs(sample.stretch - 1)
    rows = (away > 0.05 * away.max()) & (np.abs(sample.nominal) > 0)
    if not rows.any():
        return
    slope = sample.nominal[rows] / (sample.stretch[rows] - sample.stretch[rows] ** -2)
    modulus = 3 * float(np.median(slope))
    least = _ASSUMED_MODULUS if columns.strain_assumed else _MODULI[0]
    if not least < modulus < _MODULI[1] and not (spec.strain_unit is not None and modulus < _MODULI[1]):
        raise PalpateError(
            f"{path}: Young's modulus would be {1e3 * modulus:.3g} kPa, with strains up to {away.max():.3g}.",
            "No elastomer has that: state the units by --strain-unit (% or mm/mm) and --stress-unit.",
            code="modulus-implausible",
        )
