"""Deck: the same press for Abaqus and CalculiX, and CalculiX as a second solver."""

from palpate.deck.calculix import CalculixSolver, CalculixSpec, calculix_recipe, solve_press_calculix
from palpate.deck.spec import DeckElement, DeckSpec, Dialect
from palpate.deck.write_deck import deck_text, write_deck

__all__ = [
    "CalculixSolver",
    "CalculixSpec",
    "DeckElement",
    "DeckSpec",
    "Dialect",
    "calculix_recipe",
    "deck_text",
    "solve_press_calculix",
    "write_deck",
]
