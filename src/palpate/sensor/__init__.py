"""Sensor: a built unit at work: readings of its images, its acceptance, robots that it guides, ROS messages."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
