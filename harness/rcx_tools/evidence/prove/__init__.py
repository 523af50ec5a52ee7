"""Proofs that plc/lib has certain properties in every program of a user: `make prove`."""
