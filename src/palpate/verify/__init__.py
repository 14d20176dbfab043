"""Verification: problems of known solution, solved by palpate's element, contact and Newton's method."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
