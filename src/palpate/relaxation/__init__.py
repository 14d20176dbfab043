"""Relaxation: how stress and force fade while a strain stays, fitted to tests and followed through time."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
