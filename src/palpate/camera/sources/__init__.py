"""Sources of images, one file each, registered in `palpate.camera.source`."""
