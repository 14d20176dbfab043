"""A finding: one limit that a design meets, with the numbers and what to do about it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """How much a finding weighs: an error stops the chain, a warning questions the part, a note informs."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """One limit that a design meets.

    Attributes
    ----------
    severity
        How much it weighs.
    code
        Short name that does not change, e.g. ``"ring-outside-dome"``.
    message
        One sentence with the numbers and their units.
    remedy
        What to change.
    """

    severity: Severity
    code: str
    message: str
    remedy: str
