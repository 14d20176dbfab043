"""Contract suites of the extension points, for implementations of palpate and of other packages.

A test class inherits a suite and gives its fixtures; pytest collects the tests.
"""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
