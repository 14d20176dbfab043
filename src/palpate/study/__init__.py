"""Study: one YAML file through the whole chain to a specification grid, its pictures and simulator assets."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
