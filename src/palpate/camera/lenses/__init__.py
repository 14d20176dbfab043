"""Lenses, one file each, registered in `palpate.camera.lens`."""
