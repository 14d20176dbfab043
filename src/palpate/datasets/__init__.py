"""Datasets: images of markers with known poses, simulated from presses or read from recordings."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
