"""Sensor runtime of a built unit: readings, acceptance, robot alignment and ROS messages."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
