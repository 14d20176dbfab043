"""Twin: where every marker goes and what the wall bears, interpolated from presses for any pose and friction."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
