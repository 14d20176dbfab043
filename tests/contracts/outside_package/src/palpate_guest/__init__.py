"""A package that adds to palpate from outside."""
