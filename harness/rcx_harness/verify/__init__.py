"""Checks of programs and tests: debugging, exploration, proofs, storms, sweeps and properties.

This package works on any Structured Text and does not depend on one library's tests or reports.
`explore` is the only exception: it knows which variables of the library's blocks distinguish
states.
"""
