"""Long verification: published experiments and codes, repeated by the elements of palpate."""

from pathlib import Path

REFERENCE = Path(__file__).with_name("reference")
"""Folder of the published curves and tables."""
