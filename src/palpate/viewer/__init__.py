"""Viewer: what people see: the grid, the pressed dome and the live sensor in a browser."""

from palpate.viewer.server import ServeSpec, serve

__all__ = ["ServeSpec", "serve"]
