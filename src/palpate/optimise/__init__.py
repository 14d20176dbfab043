"""Design search: requirements in, the best sensors that a workshop can build out."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
