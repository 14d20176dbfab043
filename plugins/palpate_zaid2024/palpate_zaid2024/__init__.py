"""Claims: what one paper states, judged by grids and meshes."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
