"""A claim of the paper, the test that decides it, and what a study found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

MOSTLY = 0.75
"""Share of cases in which something must be so to be so in general."""


class Verdict(StrEnum):
    """What became of a claim."""

    HOLDS = "holds"
    FAILS = "does not hold"
    UNDECIDED = "not decided"


@dataclass(frozen=True)
class Claim:
    """One claim of Zaid et al. 2024 (`palpate.core.PAPER`).

    Attributes
    ----------
    name
        ``"C1"`` … ``"C14"``.
    statement
        What the paper says.
    test
        What must be so that we say it holds.
    """

    name: str
    statement: str
    test: str


@dataclass(frozen=True)
class ClaimFinding:
    """What was found about one claim.

    Attributes
    ----------
    verdict
        Computed from the figures.
    figures
        The figures that decide, in words with units.
    why
        Why it is not decided, or what a reader must know beside the figures; may be empty.
    """

    verdict: Verdict
    figures: str
    why: str = ""

    @classmethod
    def of(cls, holds: bool, figures: str, why: str = "") -> ClaimFinding:
        """The finding of a test that was made."""
        return cls(Verdict.HOLDS if holds else Verdict.FAILS, figures, why)


@dataclass(frozen=True)
class ClaimAnswer:
    """A claim with the finding of one source.

    Attributes
    ----------
    claim, finding
        What was asked and found.
    source
        The grid it was found in, e.g. ``"no-slip, best"``, or another source.
    """

    claim: Claim
    source: str
    finding: ClaimFinding


CLAIMS = {
    claim.name: claim
    for claim in (
        Claim(
            "C1",
            "Table 2 gives 0.25 MPa at stretch 5 and 0.10 MPa at half height",
            "nominal stress of the Yeoh law of Table 2 within 5 % of both",
        ),
        Claim(
            "C2",
            "Maximum stress converges to less than 5 % near 2 400 elements",
            "every mesh from at most 2 438 elements of the whole dome on is within 5 % of the finest",
        ),
        Claim(
            "C3",
            "Maximum stress at T = 2 mm: H = 10 > H = 20 > H = 30 mm",
            "greatest von Mises stress of the straight press in this order",
        ),
        Claim(
            "C4",
            "The hemisphere (H = 20 mm) deforms most",
            "at T = 1 and 2 mm H = 20 has the greatest displacement of any point (by 1 %) and the greatest mean",
        ),
        Claim(
            "C5",
            "T = 2 mm conforms to the wall; T = 1 mm inverts, more so at steeper angles",
            "T = 2 stays flat with less than 0.2 mm between wall and apex; T = 1 inverts, at steep tilts more often",
        ),
        Claim(
            "C6",
            "Mean marker travel: lowest with 7, highest with 169 markers; above 1 mm with 37, 91, 169",
            "so on every dome",
        ),
        Claim(
            "C7",
            "Mean marker travel is greatest at H = 20 mm",
            "so in at least three quarters of thicknesses and layouts",
        ),
        Claim(
            "C8",
            "Travel against T: flat at H = 10; at H = 20 and 30 mm a fast rise from 1 to 2 mm, then slow",
            "mean over layouts: at H = 10 within 10 % of T = 1; at H = 20 and 30 a rise of over 5 % from T = 1 to 2, "
            "greater than that of each later step",
        ),
        Claim(
            "C9",
            "Errors fall with the number of markers, little above 91",
            "clean RMSE falls from each count to the next on at least three quarters of the domes; from 91 to 169 it "
            "falls by less than a tenth of the fall from 7 to 91",
        ),
        Claim(
            "C10",
            "The best design is H20 T2 with 169 markers: RMSE 0.3°, maximum 0.8°",
            "it has the least clean RMSE of all, and is within both figures",
        ),
        Claim(
            "C11",
            "H = 20 mm beats H = 10 and 30 mm",
            "least clean RMSE in at least three quarters of thicknesses and layouts",
        ),
        Claim(
            "C12",
            "Thinner is more precise",
            "clean RMSE rises from each thickness to the next in at least three quarters of the steps",
        ),
        Claim(
            "C14",
            "A maximum error below 2° passes the aerospace line",
            "H20 T2 with 169 markers is below 2° on clean images",
        ),
    )
}
"""The claims that a study decides; C13 is one of the real sensor."""
