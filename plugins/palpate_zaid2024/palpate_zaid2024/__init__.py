"""Claims of one paper, assessed by grids and mesh studies."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
