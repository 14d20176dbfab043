"""Lenses, one file each; `palpate.camera.lens` knows them by name."""
