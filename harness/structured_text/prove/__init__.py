"""Proof: the checked Structured Text as formulas, and what a solver says of them."""
