"""How tests and programs are put to the test: coverage, and mutants of Structured Text.

What is measured here is any Structured Text; nothing knows the blocks, tests or reports of one
library.
"""
