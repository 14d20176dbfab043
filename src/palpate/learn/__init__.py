"""Estimators: pose of the obstacle from images of markers, with conformal intervals."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
