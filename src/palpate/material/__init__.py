"""Material: laws of elastomers, fitted to test files, and their relaxation."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
