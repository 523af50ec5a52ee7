"""Proofs of the properties of plc/lib for every user program: `make prove`."""
