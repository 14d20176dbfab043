"""Fea: press a skin by a rigid obstacle and say what it does: displacement, force, contact, stress, branch."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
