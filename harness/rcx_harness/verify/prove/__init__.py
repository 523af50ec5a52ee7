"""Proofs of a program in a cell: its surroundings, and the replay of counterexamples."""
