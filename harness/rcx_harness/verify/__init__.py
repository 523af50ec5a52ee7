"""Checks of programs and tests: debugging, exploration, proofs, storms, sweeps and properties.

This package works on any Structured Text program. Only `explore` depends on this library: it has a
list of the block variables that distinguish states.
"""
