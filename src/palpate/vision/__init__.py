"""Vision: markers in images, their assignment, their motion, and the pose of the camera."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
