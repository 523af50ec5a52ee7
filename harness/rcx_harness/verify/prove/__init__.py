"""Proofs of a program in a cell: what surrounds it, and how a found run is shown."""
