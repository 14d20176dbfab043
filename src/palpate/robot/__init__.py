"""Robot: the last metre: a tool that is squared to walls, the sensor's axes against the drill's, and ROS."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
