"""Mutants of this library, and of the parts that judge it."""
