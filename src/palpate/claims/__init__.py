"""Claims: what one paper states, judged by grids and meshes."""

from palpate.core.lazy_front import lazy_front

lazy_front(__name__, __file__)
