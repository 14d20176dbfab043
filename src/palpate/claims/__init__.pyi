"""Claims: what one paper states, judged by grids and meshes."""

from palpate.claims.claim import Claim, ClaimAnswer, ClaimFinding, Verdict
from palpate.claims.evidence import Evidence
from palpate.claims.judge_claims import assess_claims, read_evidence
from palpate.claims.write_claims import claim_report, write_claims

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
]
