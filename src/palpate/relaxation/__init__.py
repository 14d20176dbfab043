"""Relaxation: how stress and force fade while a strain stays, fitted to tests and followed through time."""

from palpate.core.lazy_front import lazy_front

lazy_front(__name__, __file__)
