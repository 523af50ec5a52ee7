"""Interfaces for what a program misses, inferred from its use, so that the rest can be checked."""
