"""Claims: what one paper states, judged by grids and meshes."""

from palpate.claims.claim import Answer, Claim, ClaimFinding, Verdict
from palpate.claims.evidence import Evidence
from palpate.claims.judge_claims import judge_claims, read_evidence
from palpate.claims.write_claims import write_claims

__all__ = [
    "Answer",
    "Claim",
    "ClaimFinding",
    "Evidence",
    "Verdict",
    "judge_claims",
    "read_evidence",
    "write_claims",
]
