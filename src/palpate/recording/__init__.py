"""Recordings: images of any sensor with dots, and poses beside them, to a model that reads it."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
