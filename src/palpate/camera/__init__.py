"""Camera: projection of points in the skin's frame to pixels, and calibration of the lens by a board."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
