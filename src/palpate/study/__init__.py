"""Study: one YAML file carried through the whole chain, on worker processes, resumed where it was."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
