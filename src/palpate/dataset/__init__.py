"""Datasets: from solved presses and a camera to images of markers with known poses."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
