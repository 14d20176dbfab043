"""Configuration of a material fit: format of test files, preparation of curves, and fit."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

from palpate.core import Spec, parameter
from palpate.material.sample import Loading

DECIMALS = {"point": ".", "comma": ","}
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}


class StrainUnit(StrEnum):
    """Unit of a column of strain."""

    RATIO = "mm/mm"
    PERCENT = "%"
    TRAVEL = "mm"
    INCH = "in"
    STRETCH = "stretch"
    LOGARITHMIC = "log"


class StressUnit(StrEnum):
    """Unit of a column of stress or force."""

    PA = "Pa"
    KPA = "kPa"
    MPA = "MPa"
    GPA = "GPa"
    N_PER_CM2 = "N/cm2"
    PSI = "psi"
    BAR = "bar"
    KGF_PER_CM2 = "kgf/cm2"
    KGF_PER_MM2 = "kgf/mm2"
    MILLINEWTON = "mN"
    NEWTON = "N"
    KILONEWTON = "kN"
    POUND_FORCE = "lbf"
    KILOGRAM_FORCE = "kgf"
    GRAM_FORCE = "gf"


class TimeUnit(StrEnum):
    """Unit of a column of time."""

    MILLISECOND = "ms"
    SECOND = "s"
    MINUTE = "min"
    HOUR = "h"


_STRAIN_UNITS = ", ".join(StrainUnit)
_STRESS_UNITS = ", ".join(StressUnit)


class TestFileSpec(Spec):
    """Format of test files; settings that are not given are read from the file, or an error asks for them."""

    loading: Loading | None = parameter(None, unit="", meaning="kind of test; empty: by file name or preamble")
    strain: str | None = parameter(None, unit="", meaning="column of strain, stretch or travel, by name or number")
    strain_unit: StrainUnit | None = parameter(
        None, unit="", meaning=f"unit of the strain column, {_STRAIN_UNITS}; empty: as in the header"
    )
    stress: str | None = parameter(None, unit="", meaning="column of stress or force, by name or number")
    stress_unit: StressUnit | None = parameter(
        None, unit="", meaning=f"unit of the stress column, {_STRESS_UNITS}; empty: as in the header"
    )
    true_stress: bool = parameter(False, unit="", meaning="whether the stress is true (Cauchy), not nominal")
    gauge_length: float | None = parameter(None, unit="mm", meaning="gauge length, for a column of travel", gt=0)
    section: float | None = parameter(
        None, unit="mm2", meaning="undeformed cross-section, for a column of force", gt=0
    )
    time: str | None = parameter(None, unit="", meaning="column of time of a relaxation test, by name or number")
    time_unit: TimeUnit | None = parameter(
        None, unit="", meaning=f"unit of the time column, {', '.join(TimeUnit)}; empty: as in the header"
    )
    sample: str | None = parameter(None, unit="", meaning="column of the sample number, by name or number")
    cycle: int | None = parameter(
        None,
        unit="1",
        meaning="cycle of a cyclic test that is fitted, at each level, with the set removed; empty: first loading",
        ge=1,
    )
    decimal: Literal["point", "comma"] | None = parameter(
        None, unit="", meaning="decimal mark, point or comma; empty: detected"
    )
    delimiter: Literal["comma", "semicolon", "tab", "space"] | None = parameter(
        None, unit="", meaning="delimiter of cells: comma, semicolon, tab or space; empty: detected"
    )


class PrepareSpec(Spec):
    """Preparation of a curve before it is fitted or averaged."""

    min_stretch: float = parameter(0.0, unit="1", meaning="minimum stretch of the rows used", ge=0, le=1)
    max_stretch: float = parameter(1e3, unit="1", meaning="maximum stretch of the rows used", gt=1)
    until_break: bool = parameter(True, unit="", meaning="cut the curve at the break or at unloading")
    toe: Literal["none", "auto"] = parameter(
        "none",
        unit="",
        meaning="toe correction: none, or auto, which shifts the strain so that the steepest tangent of the toe "
        "passes through zero",
    )
    strain_factor: float = parameter(
        1.0,
        unit="1",
        meaning="ratio of gauge strain to crosshead strain, to correct a strain from crosshead travel",
        gt=0,
    )
    points: int | None = parameter(
        100, unit="1", meaning="number of rows to which a longer sample is averaged; empty: as measured", ge=5
    )


class Weighting(StrEnum):
    """Weight of the rows in a fit."""

    UNIFORM = "uniform"
    RELATIVE = "relative"
    MODE = "mode"


class FitSpec(Spec):
    """Model and settings of a fit."""

    model: str = parameter("yeoh", unit="", meaning="model; see `palpate material fit --help`")
    weighting: Weighting = parameter(
        Weighting.UNIFORM,
        unit="",
        meaning="weight of an error: uniform: 1; relative: 1 over the stress; mode: 1 over the mode's maximum stress",
    )
    stable: bool = parameter(False, unit="", meaning="constrain the fit to Drucker stability")
    stable_from: float = parameter(
        0.05, unit="1", meaning="lower uniaxial stretch of the stability constraint and check", gt=0, lt=1
    )
    stable_to: float = parameter(
        20.0, unit="1", meaning="upper uniaxial stretch of the stability constraint and check", gt=1, le=100
    )
    confidence: float = parameter(0.95, unit="1", meaning="confidence level of the intervals", gt=0, lt=1)
    max_exponent: float = parameter(
        30.0, unit="1", meaning="maximum absolute exponent of the Ogden model", gt=1, le=300
    )
