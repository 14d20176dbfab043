"""Sources of images, one file each; `palpate.camera.source` knows them by name."""
