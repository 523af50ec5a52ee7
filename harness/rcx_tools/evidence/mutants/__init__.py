"""Mutants of this library, and of the parts that check it."""
