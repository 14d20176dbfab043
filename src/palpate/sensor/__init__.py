"""Sensor: a built unit at work: from its images to readings, with what may be wrong about them."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
