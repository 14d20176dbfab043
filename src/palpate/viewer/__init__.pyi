"""Viewer: what people see: the grid, the pressed dome and the live sensor in a browser."""

from palpate.viewer.opened_results import find_results
from palpate.viewer.readings_client import follow_readings
from palpate.viewer.serve_readings import Feed, build_readings_app, serve_readings
from palpate.viewer.server import ServeSpec, serve

__all__ = [
    "Feed",
    "ServeSpec",
    "build_readings_app",
    "find_results",
    "follow_readings",
    "serve",
    "serve_readings",
]
