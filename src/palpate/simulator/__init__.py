"""Simulator: a sensor as an asset of MuJoCo, of URDF or of USD: mesh, mass, camera, frames and how it yields."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
