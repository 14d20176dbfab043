"""Built: a unit as it was built: tolerances, what its images tell of it, poses by fit, and how good it will be."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
