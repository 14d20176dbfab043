"""A sample: one specimen in one test, as stretch and nominal stress."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

from palpate.core import BoolArray, FloatArray, IntArray
from palpate.material.curve import Mode, stretches


class Loading(StrEnum):
    """Loading of a specimen.

    Tension and compression are the two halves of the uniaxial mode; `UNIAXIAL` is a file with both, signed.
    """

    TENSION = "tension"
    COMPRESSION = "compression"
    UNIAXIAL = "uniaxial"
    EQUIBIAXIAL = "equibiaxial"
    PLANAR = "planar"

    @property
    def mode(self) -> Mode:
        """Mode of deformation."""
        return Mode.UNIAXIAL if self in (Loading.TENSION, Loading.COMPRESSION) else Mode(str(self))


@dataclass(frozen=True)
class Sample:
    """One specimen in one test.

    Attributes
    ----------
    name
        File, and number of the specimen in it.
    loading
        The test.
    stretch
        (n,) of the pulled or pressed direction; 1 is rest.
    nominal
        (n,) nominal stress, MPa; compression is negative.
    notes
        Changes by the reader, for the report.
    """

    name: str
    loading: Loading
    stretch: FloatArray
    nominal: FloatArray
    notes: tuple[str, ...] = ()

    @property
    def mode(self) -> Mode:
        """Mode of deformation."""
        return self.loading.mode

    @property
    def principal(self) -> FloatArray:
        """Principal stretches (n, 3) of the incompressible specimen."""
        return stretches(self.mode, self.stretch)

    def where(self, selected: BoolArray | IntArray) -> Sample:
        """Return the sample with the selected rows: a mask (n,), or their numbers in the order wanted."""
        return replace(self, stretch=self.stretch[selected], nominal=self.nominal[selected])
