"""Ladder routines of an L5X: rungs in neutral text, and their translation to Structured Text."""
