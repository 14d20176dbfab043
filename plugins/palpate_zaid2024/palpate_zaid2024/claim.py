"""A claim of the paper, the test that decides it, and the finding of a study."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

MOSTLY = 0.75
"""Share of the cases in which a statement must be true to count as generally true."""


class Verdict(StrEnum):
    """Result of the test of a claim."""

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
        Statement of the paper.
    test
        Condition under which the claim holds.
    """

    name: str
    statement: str
    test: str


@dataclass(frozen=True)
class ClaimFinding:
    """Finding of a study about one claim.

    Attributes
    ----------
    verdict
        Computed from the figures.
    figures
        The figures that decide, as text with units.
    why
        Reason why the claim is not decided, or a remark on the figures; may be empty.
    """

    verdict: Verdict
    figures: str
    why: str = ""

    @classmethod
    def of(cls, holds: bool, figures: str, why: str = "") -> ClaimFinding:
        """Return the finding of a completed test."""
        return cls(Verdict.HOLDS if holds else Verdict.FAILS, figures, why)


@dataclass(frozen=True)
class ClaimAnswer:
    """A claim with the finding of one source.

    Attributes
    ----------
    claim, finding
        Claim, and the finding about it.
    source
        Grid of the finding, e.g. ``"no-slip, best"``, or another source.
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
            "nominal stress of the Yeoh law of Table 2 is within 5 % of these two values",
        ),
        Claim(
            "C2",
            "Maximum stress converges to less than 5 % near 2 400 elements",
            "from at most 2 438 elements of the whole dome upwards, every mesh is within 5 % of the finest",
        ),
        Claim(
            "C3",
            "Maximum stress at T = 2 mm: H = 10 > H = 20 > H = 30 mm",
            "maximum von Mises stress of the straight press in this order",
        ),
        Claim(
            "C4",
            "The hemisphere (H = 20 mm) deforms most",
            "at T = 1 and 2 mm, H = 20 has the largest maximum displacement (by over 1 %) and the largest mean",
        ),
        Claim(
            "C5",
            "T = 2 mm conforms to the wall; T = 1 mm inverts, more so at steeper angles",
            "T = 2 stays flat with less than 0.2 mm between wall and apex; T = 1 inverts, at steep tilts more often",
        ),
        Claim(
            "C6",
            "Mean marker travel: lowest with 7, highest with 169 markers; above 1 mm with 37, 91, 169",
            "true on every dome",
        ),
        Claim(
            "C7",
            "Mean marker travel is largest at H = 20 mm",
            "true in at least three quarters of the combinations of thickness and layout",
        ),
        Claim(
            "C8",
            "Travel against T: flat at H = 10; at H = 20 and 30 mm a fast rise from 1 to 2 mm, then a slow one",
            "mean over layouts: at H = 10 within 10 % of that at T = 1; at H = 20 and 30 a rise of over 5 % from "
            "T = 1 to 2, larger than that of each later step",
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
            "it has the smallest clean RMSE of all designs, and neither of its errors exceeds these values",
        ),
        Claim(
            "C11",
            "H = 20 mm beats H = 10 and 30 mm",
            "smallest clean RMSE in at least three quarters of the combinations of thickness and layout",
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
"""The claims that a study can decide; C13 concerns the real sensor."""
