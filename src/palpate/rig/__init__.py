"""Acquisition of recordings on a rig: robots by name, plan of presses, image check, resumable folder."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
