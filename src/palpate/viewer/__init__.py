"""Viewer: what people see: the grid, the pressed dome and the live sensor in a browser."""
