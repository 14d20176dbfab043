"""What a person may choose: how a bench's files are to be read, how curves are prepared, and how they are fitted."""

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
    STRETCH = "stretch"
    LOGARITHMIC = "log"


class StressUnit(StrEnum):
    """Unit of a column of stress or force."""

    PA = "Pa"
    KPA = "kPa"
    MPA = "MPa"
    PSI = "psi"
    MILLINEWTON = "mN"
    NEWTON = "N"
    KILONEWTON = "kN"


class TimeUnit(StrEnum):
    """Unit of a column of time."""

    MILLISECOND = "ms"
    SECOND = "s"
    MINUTE = "min"
    HOUR = "h"


_STRAIN_UNITS = ", ".join(StrainUnit)
_STRESS_UNITS = ", ".join(StressUnit)


class TestFileSpec(Spec):
    """How the files of a test bench are to be read; what is left open is found in the file or asked for."""

    loading: Loading | None = parameter(None, unit="", meaning="the test; empty: as file name or preamble say")
    strain: str | None = parameter(None, unit="", meaning="column of strain, stretch or travel: name or number")
    strain_unit: StrainUnit | None = parameter(
        None, unit="", meaning=f"its unit, {_STRAIN_UNITS}; empty: as the header says"
    )
    stress: str | None = parameter(None, unit="", meaning="column of stress or force: name or number")
    stress_unit: StressUnit | None = parameter(
        None, unit="", meaning=f"its unit, {_STRESS_UNITS}; empty: as the header says"
    )
    true_stress: bool = parameter(False, unit="", meaning="whether the stress is true (Cauchy), not nominal")
    gauge_length: float | None = parameter(None, unit="mm", meaning="gauge length, for a column of travel", gt=0)
    section: float | None = parameter(None, unit="mm2", meaning="undeformed section, for a column of force", gt=0)
    time: str | None = parameter(None, unit="", meaning="column of time of a relaxation test: name or number")
    time_unit: TimeUnit | None = parameter(
        None, unit="", meaning=f"its unit, {', '.join(TimeUnit)}; empty: as the header says"
    )
    sample: str | None = parameter(None, unit="", meaning="column that numbers the samples: name or number")
    decimal: Literal["point", "comma"] | None = parameter(
        None, unit="", meaning="decimal mark, point or comma; empty: found"
    )
    delimiter: Literal["comma", "semicolon", "tab", "space"] | None = parameter(
        None, unit="", meaning="what stands between cells: comma, semicolon, tab or space; empty: found"
    )


class PrepareSpec(Spec):
    """What is done to a curve before it is fitted or averaged."""

    min_stretch: float = parameter(0.0, unit="1", meaning="rows of smaller stretch are left out", ge=0, le=1)
    max_stretch: float = parameter(1e3, unit="1", meaning="rows of greater stretch are left out", gt=1)
    until_break: bool = parameter(True, unit="", meaning="cut where the specimen breaks or is unloaded")
    toe: Literal["none", "auto"] = parameter(
        "none",
        unit="",
        meaning="none, or auto: shift the strain so that the steepest line of the toe passes through zero",
    )
    strain_factor: float = parameter(
        1.0, unit="1", meaning="gauge over crosshead strain, to correct a strain of crosshead travel", gt=0
    )
    points: int | None = parameter(
        100, unit="1", meaning="rows to which a longer sample is averaged; empty: as measured", ge=5
    )


class Weighting(StrEnum):
    """What each row of a fit weighs."""

    UNIFORM = "uniform"
    RELATIVE = "relative"
    MODE = "mode"


class FitSpec(Spec):
    """How a model is fitted."""

    model: str = parameter("yeoh", unit="", meaning="model; see `palpate material fit --help`")
    weighting: Weighting = parameter(
        Weighting.UNIFORM,
        unit="",
        meaning="uniform: an error counts as it is; relative: over its stress; mode: over the greatest of its mode",
    )
    stable: bool = parameter(False, unit="", meaning="hold the fit to Drucker's stability")
    stable_from: float = parameter(
        0.05, unit="1", meaning="uniaxial stretch from which stability is held and scanned", gt=0, lt=1
    )
    stable_to: float = parameter(
        20.0, unit="1", meaning="uniaxial stretch to which stability is held and scanned", gt=1, le=100
    )
    confidence: float = parameter(0.95, unit="1", meaning="confidence of the intervals", gt=0, lt=1)
    max_exponent: float = parameter(30.0, unit="1", meaning="bound of Ogden's exponents", gt=1, le=300)
