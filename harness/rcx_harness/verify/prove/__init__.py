"""Proofs of a program in a cell: the program's surroundings and replays of counterexamples."""
