"""Hyperelastic laws, one file each; `palpate.material.make_law` knows them by name."""
