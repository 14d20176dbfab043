"""Camera: from points in the dome's frame to pixels and back to rays; the lens from images of a board."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
