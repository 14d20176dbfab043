"""Grid: the specification grid of a study, its questions and its pictures."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
