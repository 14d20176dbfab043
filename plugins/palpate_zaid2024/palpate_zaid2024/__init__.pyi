"""Claims of one paper, assessed by grids and mesh studies."""

from palpate_zaid2024.assess_claims import assess_claims, read_evidence
from palpate_zaid2024.claim import Claim, ClaimAnswer, ClaimFinding, Verdict
from palpate_zaid2024.evidence import Evidence
from palpate_zaid2024.write_claims import claim_report, write_claims
from palpate_zaid2024.write_figures import write_figures

__all__ = [
    "Claim",
    "ClaimAnswer",
    "ClaimFinding",
    "Evidence",
    "Verdict",
    "assess_claims",
    "claim_report",
    "read_evidence",
    "write_claims",
    "write_figures",
]
