"""The command line: a thin door. It reads flags, calls the stages and prints."""

from palpate.cli.app import main

__all__ = ["main"]
