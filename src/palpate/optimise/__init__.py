"""Design search: requirements in, the best sensors that a workshop can build out."""

from palpate.core.lazy_front import lazy_front

lazy_front(__name__, __file__)
