"""Verify: problems with known answers, solved by the package's own element, contact and Newton's method."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
