"""Contract suites: what every implementation of a contract must satisfy, for the package's own and for others.

A test class inherits a suite and gives its fixtures; pytest, which this room alone needs, collects the rest.
"""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
