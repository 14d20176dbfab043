"""Learning: from images of markers, simulated or recorded, to the pose of the wall with an honest interval."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
