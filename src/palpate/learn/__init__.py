"""Learning: from images of markers to the pose of the wall, and how good any estimator could be."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
