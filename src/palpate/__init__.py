"""palpate: from an idea to a trusted vision-based tactile sensor."""

__version__ = "0.1.0"
