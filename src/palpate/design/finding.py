"""Finding: one limit that a design exceeds, with values and remedy."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """Severity of a finding: an error stops the computation, a warning questions the part, a note informs."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """One limit that a design exceeds, with a permanent short `code` such as ``"ring-outside-dome"``.

    The `message` is one sentence with the numbers and their units, the `remedy` a recommended change.
    """

    severity: Severity
    code: str
    message: str
    remedy: str
