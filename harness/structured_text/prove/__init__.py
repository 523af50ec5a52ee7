"""Proofs: translate checked Structured Text into formulas, and let a solver (Z3) decide them."""
