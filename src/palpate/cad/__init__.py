"""Cad: outlines, and the solids that are made from them. The only room that knows the CAD kernel."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
