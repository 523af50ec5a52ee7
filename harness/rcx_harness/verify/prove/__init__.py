"""Proofs of a program in a cell: its free inputs, and replays of counterexamples."""
