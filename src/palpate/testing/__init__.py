"""Contract suites: what every implementation of a contract must satisfy, for the package's own and for others.

A test class inherits a suite and gives its fixtures; pytest, which this room alone needs, collects the rest.
"""

from palpate.testing.law import LawSuite
from palpate.testing.lens import LensSuite

__all__ = ["LawSuite", "LensSuite"]
