"""Checks of programs and tests: debugging, exploration, proofs, storms, sweeps and properties.

This package works on any Structured Text program. Only `explore` depends on the RCX3 function
blocks: it lists the block variables that distinguish states.
"""
