"""Viewer: specification grid, pressed skin and live sensor in a browser."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
