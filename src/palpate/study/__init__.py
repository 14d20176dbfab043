"""Study: one YAML file, run from the designs to a specification grid, figures and simulator assets."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
