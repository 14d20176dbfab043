"""Viewer: what people see: the grid, the pressed dome and the live sensor in a browser."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
