"""How tests and programs are put to the test: coverage, mutants, campaigns of faults.

What is measured here is any Structured Text; nothing knows the blocks, tests or reports of one
library.
"""
