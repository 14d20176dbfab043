"""Design search: from requirements to the most accurate sensors that a workshop can build."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
