"""Marker detection, assignment and tracking in images, and registration of the camera."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
